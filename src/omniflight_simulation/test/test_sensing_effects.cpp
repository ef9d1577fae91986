// What the effects on sensors do to the measured signal: geometry of the capture system, clocks, filters and
// modes by their response to a harmonic, and the speed sensor of a rotor that turns.
#include <gtest/gtest.h>

#include <complex>

#include "flying.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {
namespace {

constexpr double kStep = 0.001;

physics::Model with(const char* id, std::vector<double> theta) {
  physics::Model m;
  m.effects.push_back({physics::find_effect(id), std::move(theta)});
  return m;
}

/// Flies `steps` steps with the sensors of a model whose wrench is nothing; `each` sees every frame.
template <class Each>
void fly(const physics::Model& model, Plant& plant, int steps, bool held, Each&& each) {
  SensorSuite suite({}, model, kStep, 1);
  SensorFrame frame;
  for (int k = 0; k < steps; ++k) {
    suite.sample(plant, frame);
    each(frame);
    ASSERT_TRUE(plant.step(held));
  }
}

/// Weightless, so that nothing but the initial motion is to be seen.
PlantConfig weightless() {
  PlantConfig c;
  c.environment.gravity = 0;
  return c;
}

TEST(MocapTilt, LeansTheWorldInWhichPositionAndGravityAreMeasured) {
  const Vec3 lean(0.02, -0.03, 0);
  const Mat3 R = Eigen::AngleAxisd(lean.norm(), lean.normalized()).toRotationMatrix();
  PlantConfig c;
  c.initial.p_WB = Vec3(1, -2, 3);
  c.initial.q_WB = exp_rotation(Vec3(0.3, 0.1, -0.5));
  Plant plant = make(omnimorph(), {}, c);
  int frames = 0;
  fly(with("mocap_tilt", {lean.x(), lean.y()}), plant, 20, true, [&](const SensorFrame& f) {
    if (!f.mocap) return;
    ++frames;
    EXPECT_LT((f.mocap_sample.p_WB - R * c.initial.p_WB).norm(), 1e-12);
    EXPECT_GT((f.mocap_sample.p_WB - c.initial.p_WB).norm(), 0.05);
    // the accelerometer is not tilted: what it feels, turned into the measured world, is not vertical there
    const Vec3 up = f.mocap_sample.q_WB * f.imu_sample.specific_force_B / kGravity;
    EXPECT_LT((up - R * Vec3::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(std::acos(up.z()), lean.norm(), 1e-6);
  });
  EXPECT_EQ(frames, 5);
}

TEST(MocapOffset, CirclesAroundABodyThatTurnsInPlaceAndTurnsItsAxes) {
  const Vec3 offset(0.03, 0.04, 0.01), turned(0.02, -0.01, 0.05);
  PlantConfig c = weightless();
  c.initial.p_WB = Vec3(0.5, 1, 2);
  c.initial.w_WB_B = Vec3(0, 0, 3);
  Plant plant = make(omnimorph(), {}, c);
  double before = std::numeric_limits<double>::quiet_NaN(), angle = 0;
  int frames = 0;
  fly(with("mocap_offset", {0.03, 0.04, 0.01, 0.02, -0.01, 0.05}), plant, 1001, false,
      [&](const SensorFrame& f) {
        if (!f.mocap) return;
        const Vec3 d = f.mocap_sample.p_WB - c.initial.p_WB;
        EXPECT_NEAR(d.head<2>().norm(), 0.05, 1e-9);
        EXPECT_NEAR(d.z(), 0.01, 1e-9);
        const double now = std::atan2(d.y(), d.x());
        if (frames++ > 0) angle += std::remainder(now - before, 2 * kPi);
        before = now;
        EXPECT_LT((log_rotation(plant.body().q_WB.conjugate() * f.mocap_sample.q_WB) - turned).norm(), 1e-9);
      });
  EXPECT_EQ(frames, 251);
  EXPECT_NEAR(angle, 3.0 * 1.0, 1e-6) << "a second at 3 rad/s";
}

TEST(ClockOffset, ShiftsAPassingVehicleAndStretchesItsSpeed) {
  // a vehicle that passes at 2 m/s: in the time of the stamps it is t_d ahead and faster by the skew
  const double late = 0.02, skew = 8e-4;
  PlantConfig c = weightless();
  c.initial.v_WB_W.x() = 2;
  Plant plant = make(omnimorph(), {}, c);
  std::vector<double> t, x, board;
  fly(with("clock_offset", {late, skew}), plant, 5000, false, [&](const SensorFrame& f) {
    if (!f.mocap) return;
    t.push_back(f.mocap_sample.t);
    x.push_back(f.mocap_sample.p_WB.x());
    board.push_back(f.imu_sample.t);
  });
  const double speed = (x.back() - x.front()) / (t.back() - t.front());
  EXPECT_NEAR(speed / 2 - 1, skew, 1e-9);
  EXPECT_NEAR(x.front() - speed * t.front(), 2 * late, 1e-9);
  EXPECT_NEAR((x.back() - x.front()) / (board.back() - board.front()), 2, 1e-9)
      << "the boards' clock is true";
}

/// Shakes the body along x and about x.
struct Shaker final : Disturbance {
  double rate;  ///< rad/s
  explicit Shaker(double hz) : rate(2 * kPi * hz) {}
  void add_wrench(const physics::Situation& s, physics::Wrench& out) const override {
    out.force_B.x() += std::sin(rate * s.t);
    out.torque_B.x() += 0.02 * std::sin(rate * s.t);
  }
};

/// What the sensors make of a harmonic of this frequency [Hz, whole] over what is there, once transients are
/// gone.
struct Gain {
  double acc = 0, gyro = 0;
};
Gain gain(const physics::Model& model, int hz) {
  Plant plant = make(omnimorph(), {}, {});
  const Shaker shaker(hz);
  plant.set_disturbance(&shaker);
  std::complex<double> acc, gyro, true_acc, true_gyro;
  fly(model, plant, 4000, false, [&](const SensorFrame& f) {
    if (plant.time() < 3 - 0.5 * kStep) return;  // a second, which has whole periods
    const std::complex<double> wave = std::polar(1.0, -shaker.rate * plant.time());
    acc += wave * f.imu_sample.specific_force_B.x();
    gyro += wave * f.imu_sample.gyro_B.x();
    true_acc += wave * plant.specific_force().x();
    true_gyro += wave * plant.body().w_WB_B.x();
  });
  EXPECT_GT(std::abs(true_acc), 100);
  EXPECT_GT(std::abs(true_gyro), 1);
  return {std::abs(acc / true_acc), std::abs(gyro / true_gyro)};
}

/// Second-order low-pass at `ratio` times its frequency.
std::complex<double> low_pass(double ratio, double damping) {
  return 1.0 / std::complex<double>(1 - ratio * ratio, 2 * damping * ratio);
}

TEST(StructuralMode, ShakesTheImuAtItsFrequencyAndSoftensWhatIsFaster) {
  const double share = 0.5, damping = 0.05;
  const physics::Model m = with("structural_mode", {share, 20, damping});
  for (const int hz : {4, 20, 60}) {
    const double expected = std::abs(1.0 + share * (low_pass(hz / 20.0, damping) - 1.0));
    const Gain g = gain(m, hz);
    EXPECT_NEAR(g.acc / expected, 1, 0.02) << hz << " Hz";
    EXPECT_NEAR(g.gyro / expected, 1, 0.02) << hz << " Hz";
  }
  EXPECT_GT(gain(m, 20).acc, 4.9) << "half of the ten-fold resonance, and the rest of the frame";
}

TEST(SensorFilter, PassesWhatIsSlowAndWeakensWhatIsFast) {
  const double time = 1 / (2 * kPi * 40), damping = 0.7;
  const physics::Model acc = with("sensor_filter", {0, time, damping}),
                       gyro = with("sensor_filter", {time, 0, damping});
  for (const int hz : {4, 40, 80}) {
    const double expected = std::abs(low_pass(hz / 40.0, damping));
    EXPECT_NEAR(gain(acc, hz).acc / expected, 1, 0.02) << hz << " Hz";
    EXPECT_NEAR(gain(gyro, hz).gyro / expected, 1, 0.02) << hz << " Hz";
    EXPECT_NEAR(gain(acc, hz).gyro, 1, 1e-9) << "each has a filter of its own";
    EXPECT_NEAR(gain(gyro, hz).acc, 1, 1e-9);
  }
}

TEST(Vibration, OfAnUnbalancedRotorIsRectifiedIntoABias) {
  const double imbalance = 2e-5, rectification = 0.05, speed = 2 * kPi * 50;
  const double size = imbalance * speed * speed;  // m/s^2, of a vector that turns with the rotor
  Plant plant = make(omnimorph(), {}, {});
  for (std::size_t i = 0; i < 8; ++i) plant.seize_rotor(i, i == 0 ? speed : 0.0);
  ASSERT_TRUE(plant.step(true));
  Vec3 mean = Vec3::Zero();
  double squares = 0;
  const double rest = plant.specific_force().z();
  fly(with("vibration", {imbalance, rectification}), plant, 1000, true, [&](const SensorFrame& f) {
    mean += f.imu_sample.specific_force_B / 1000;
    squares += f.imu_sample.specific_force_B.head<2>().squaredNorm() / 1000;
  });
  EXPECT_NEAR(std::sqrt(squares) / size, 1, 1e-6);
  EXPECT_LT(mean.head<2>().norm(), 1e-6 * size);
  EXPECT_NEAR((mean.z() - rest) / (rectification * size * size), 1, 1e-6);
  EXPECT_GT(mean.z() - rest, 0.1);
}

TEST(RotorSpeedSensorFault, ScalesAndFreezesTheReportOfARotorThatTurns) {
  const auto v = omnimorph();
  for (const bool freezes : {false, true}) {
    Plant plant = make(v, {}, {});
    SensorSuite suite({}, with("rotor_speed_sensor_fault", {3, 0.1, 5, freezes ? 0.5 : 1e6}), kStep, 1);
    SensorFrame f;
    double stuck = 0;
    int after = 0;
    for (int k = 0; k < 1000; ++k) {
      const double t = plant.time();
      plant.set_command(std::vector<double>(8, 600 + 200 * std::sin(12 * t)), 0);
      suite.sample(plant, f);
      if (f.rotor && t > 0.1) {
        const auto speed = plant.rotor_speed();
        for (std::size_t i = 0; i < 8; ++i) {
          if (i == 2) continue;
          EXPECT_EQ(f.rotor_sample.speed[i], speed[i]) << i;
        }
        EXPECT_GT(speed[2], 300);
        const double scaled = 1.1 * speed[2] + 5;
        if (!freezes || t < 0.5 - 0.5 * kStep) {
          EXPECT_NEAR(f.rotor_sample.speed[2], scaled, 1e-9) << t;
        } else {
          if (after++ == 0) stuck = scaled;
          EXPECT_NEAR(f.rotor_sample.speed[2], stuck, 1e-9) << t;
        }
      }
      ASSERT_TRUE(plant.step(true));
    }
    EXPECT_EQ(after, freezes ? 125 : 0);
    EXPECT_GT(std::abs(1.1 * plant.rotor_speed()[2] + 5 - stuck), 20) << "the rotor goes on";
  }
}

}  // namespace
}  // namespace omniflight::simulation
