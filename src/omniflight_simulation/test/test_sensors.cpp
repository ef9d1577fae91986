// Every habit of a sensor, measured from what comes out of it.
#include <gtest/gtest.h>

#include "flying.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::simulation {
namespace {

constexpr double kStep = 0.001;

/// A vehicle that hangs still: specific force (0, 0, g), no rate.
template <class Each>
void hang(const SensorConfig& config, int steps, std::uint64_t seed, Each&& each,
          const physics::Model& model = {}) {
  Plant plant = make(omnimorph(), {}, {});
  SensorSuite suite(config, model, kStep, seed);
  SensorFrame frame;
  for (int k = 0; k < steps; ++k) {
    suite.sample(plant, frame);
    each(frame, plant.time());
    ASSERT_TRUE(plant.step(true));
  }
}

/// An alteration of sensing, as effects bring it.
struct Alteration final : physics::Effect {
  physics::Sensing change;
  const physics::EffectInfo& info() const override {
    static const physics::EffectInfo i = [] {
      physics::EffectInfo made;
      made.id = "alteration";
      made.stage = physics::Stage::sensing;
      return made;
    }();
    return i;
  }
  void alter_sensing(const double*, physics::Sensing& s) const override { s = change; }
};

physics::Model altered(const Alteration& a) {
  physics::Model m;
  m.effects.push_back({&a, {}});
  return m;
}

struct Statistics {
  double n = 0, sum = 0, squares = 0;
  void add(double x) { ++n, sum += x, squares += x * x; }
  double mean() const { return sum / n; }
  double rms() const { return std::sqrt(squares / n - mean() * mean()); }
};

TEST(Mocap, SendsAtItsRateEvenWhereStepsDoNotDivideIt) {
  for (const double rate : {100.0, 120.0, 180.0, 240.0, 250.0}) {
    SensorConfig c;
    c.mocap_rate = rate;
    int frames = 0;
    double last = -1 / rate;
    hang(c, 10000, 1, [&](const SensorFrame& f, double) {
      if (!f.mocap) return;
      ++frames;
      EXPECT_NEAR(f.mocap_sample.t - last, 1 / rate, kStep);
      last = f.mocap_sample.t;
    });
    EXPECT_NEAR(frames, 10 * rate, 1) << rate;
  }
}

TEST(Mocap, ArrivesLateByItsLatencyExactToTheStep) {
  for (const double latency : {0.0, 0.001, 0.007, 0.0125, 0.05}) {
    SensorConfig c;
    c.mocap_latency = latency;
    int frames = 0;
    hang(c, 1000, 1, [&](const SensorFrame& f, double now) {
      if (!f.mocap) return;
      ++frames;
      EXPECT_NEAR(now - f.mocap_sample.t, std::llround(latency / kStep) * kStep, 1e-9);
    });
    EXPECT_GT(frames, 230);
  }
}

TEST(Mocap, LosesItsShareOfFramesInGapsOfItsLength) {
  SensorConfig c;
  c.mocap_dropout = 0.2;
  for (const double length : {1.0, 5.0}) {
    c.mocap_dropout_length = length;
    double last = 0, gaps = 0, missing = 0;
    int frames = 0;
    hang(c, 200000, 3, [&](const SensorFrame& f, double) {
      if (!f.mocap) return;
      ++frames;
      const double lost = std::round((f.mocap_sample.t - last) / 0.004) - 1;
      if (lost > 0 && frames > 1) ++gaps, missing += lost;
      last = f.mocap_sample.t;
    });
    EXPECT_NEAR(1 - frames / 50000.0, 0.2, 0.02) << length;
    EXPECT_NEAR(missing / gaps, length == 1 ? 1.25 : 5.0, 0.25);  // single losses meet by chance
  }
}

TEST(Mocap, NoiseAndStampJitterHaveTheirSize) {
  SensorConfig c;
  c.mocap_position_noise = 2e-4;
  c.mocap_attitude_noise = 8e-4;
  c.mocap_stamp_jitter = 1e-4;
  Statistics x, roll, stamp;
  hang(c, 40000, 5, [&](const SensorFrame& f, double now) {
    if (!f.mocap) return;
    x.add(f.mocap_sample.p_WB.x());
    roll.add(log_rotation(f.mocap_sample.q_WB).x());
    stamp.add(f.mocap_sample.t - now);
  });
  EXPECT_NEAR(x.rms() / 2e-4, 1, 0.03);
  EXPECT_NEAR(roll.rms() / 8e-4, 1, 0.03);
  EXPECT_NEAR(stamp.rms() / 1e-4, 1, 0.03);
}

TEST(Imu, WhiteNoiseHasTheDensityOfTheDataSheetAtAnyRate) {
  // averages over a time T of noise of one-sided density N have the variance N^2 / (2 T)
  for (const double rate : {250.0, 1000.0}) {
    SensorConfig c;
    c.imu_rate = rate;
    c.accelerometer_noise_density = 2e-3;
    c.gyro_noise_density = 1e-4;
    Statistics acc, gyro, slow;
    double sum = 0;
    int n = 0;
    hang(c, 100000, 7, [&](const SensorFrame& f, double) {
      if (!f.imu) return;
      acc.add(f.imu_sample.specific_force_B.x());
      gyro.add(f.imu_sample.gyro_B.y());
      sum += f.imu_sample.specific_force_B.x();
      if (++n == static_cast<int>(rate / 10)) slow.add(sum / n), sum = 0, n = 0;
    });
    EXPECT_NEAR(acc.rms() / (2e-3 * std::sqrt(rate / 2)), 1, 0.03);
    EXPECT_NEAR(gyro.rms() / (1e-4 * std::sqrt(rate / 2)), 1, 0.03);
    EXPECT_NEAR(slow.rms() / std::sqrt(2e-3 * 2e-3 / (2 * 0.1)), 1, 0.1);
  }
}

TEST(Imu, BiasWalksWithTheRootOfTime) {
  SensorConfig c;
  c.gyro_bias_walk = 0.01;
  Statistics end;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
    hang(c, 400, seed, [&](const SensorFrame& f, double t) {
      if (t > 0.3985) end.add(f.imu_sample.gyro_B.z());
    });
  EXPECT_NEAR(end.rms() / (0.01 * std::sqrt(0.4)), 1, 0.12);
}

TEST(Imu, BiasScaleAndMisalignmentAct) {
  SensorConfig c;
  c.accelerometer_bias = Vec3(0.1, 0, -0.2);
  c.accelerometer_scale = Vec3(0, 0, 0.01);
  c.accelerometer_misalignment = Vec3(0, 0.02, 0);
  c.gyro_bias = Vec3(0.01, 0.02, 0.03);
  hang(c, 10, 1, [&](const SensorFrame& f, double) {
    EXPECT_LT((f.imu_sample.specific_force_B - Vec3(0.1 + 0.02 * 9.81, 0, 9.81 * 1.01 - 0.2)).norm(), 1e-12);
    EXPECT_LT((f.imu_sample.gyro_B - c.gyro_bias).norm(), 1e-15);
  });
  PlantConfig spinning;
  spinning.initial.w_WB_B = Vec3(0, 0, 3);
  Plant plant = make(omnimorph(), {}, spinning);
  c.gyro_bias.setZero();
  c.gyro_scale = Vec3(0, 0, -0.02);
  SensorSuite suite(c, {}, kStep, 1);
  SensorFrame frame;
  suite.sample(plant, frame);
  EXPECT_NEAR(frame.imu_sample.gyro_B.z(), 3 * 0.98, 1e-12);
}

TEST(Imu, FeelsTheTurningOfItsLever) {
  auto v = omnimorph();
  v.inertia = Vec3(0.01, 0.01, 0.02).asDiagonal();
  PlantConfig falling;
  falling.initial.w_WB_B = Vec3(0, 0, 4);
  Plant plant = make(v, {}, falling);
  SensorConfig c;
  c.imu_position = Vec3(0.03, -0.02, 0.05);
  SensorSuite suite(c, {}, kStep, 1);
  SensorFrame frame;
  ASSERT_TRUE(plant.step());
  suite.sample(plant, frame);  // in free fall only the centripetal part is left: -w^2 r in the plane
  EXPECT_LT((frame.imu_sample.specific_force_B - Vec3(-16 * 0.03, 16 * 0.02, 0)).norm(), 1e-9);
  // and with a torque the tangential part: dw x r
  for (std::size_t i = 0; i < 8; ++i) plant.seize_rotor(i, i < 4 ? 600.0 : 0.0);
  ASSERT_TRUE(plant.step());
  suite.sample(plant, frame);
  const Vec3 w = plant.body().w_WB_B, r = c.imu_position, dw = plant.angular_acceleration();
  EXPECT_GT(std::abs(dw.z()), 1.0);
  EXPECT_LT(
      (frame.imu_sample.specific_force_B - plant.specific_force() - dw.cross(r) - w.cross(w.cross(r))).norm(),
      1e-12);
}

TEST(Imu, GyroFilterLagsARampByItsTimeAndPassesRest) {
  // a second-order low-pass of cut-off f_c and damping z answers a ramp late by 2 z / (2 pi f_c)
  auto v = omnimorph();
  v.inertia = Vec3(0.01, 0.01, 0.02).asDiagonal();
  Plant plant = make(v, {}, {});
  for (std::size_t i = 0; i < 8; ++i) plant.seize_rotor(i, i < 4 ? 60.0 : 0.0);
  SensorConfig c;
  c.gyro_filter = 40;
  SensorSuite suite(c, {}, kStep, 1);
  SensorFrame frame;
  for (int k = 0; k < 400; ++k) {
    suite.sample(plant, frame);
    ASSERT_TRUE(plant.step());
  }
  suite.sample(plant, frame);
  const double slope = plant.angular_acceleration().z();
  const double late = (plant.body().w_WB_B.z() - frame.imu_sample.gyro_B.z()) / slope;
  EXPECT_NEAR(late, 2 * std::sqrt(0.5) / (2 * kPi * 40), 0.6 * kStep);
  SensorConfig still = c;
  still.gyro_bias = Vec3(0.1, 0.2, 0.3);
  hang(still, 5, 1, [&](const SensorFrame& f, double) {
    EXPECT_LT((f.imu_sample.gyro_B - still.gyro_bias).norm(), 1e-12);
  });
}

TEST(Boards, StampWithTheirOwnClock) {
  SensorConfig c;
  c.board_clock_offset = 0.25;
  c.board_clock_skew = 4e-5;
  c.battery_rate = 10;
  hang(c, 2000, 1, [&](const SensorFrame& f, double t) {
    const double board = (1 + 4e-5) * t + 0.25;
    EXPECT_DOUBLE_EQ(f.imu_sample.t, board);
    if (f.rotor) {
      EXPECT_DOUBLE_EQ(f.rotor_sample.t, board);
    }
    if (f.battery) {
      EXPECT_DOUBLE_EQ(f.battery_sample.t, board);
    }
    if (f.mocap) {
      EXPECT_DOUBLE_EQ(f.mocap_sample.t, t);
    }  // another clock
  });
}

TEST(Battery, SagsWithCurrentAndEnergy) {
  SensorConfig c;
  c.battery_rate = 100;
  c.battery_sag = 1e-3;
  Plant plant = make(omnimorph(), {}, {});
  ASSERT_TRUE(plant.set_command(std::vector<double>(8, 800.0), 0));
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(plant.step(true));  // speed and power are steady now
  SensorSuite suite(c, {}, kStep, 1);
  SensorFrame frame;
  suite.sample(plant, frame);
  const double power = plant.mechanical_power() / c.drive_efficiency;
  EXPECT_NEAR(frame.battery_sample.current, power / 16.8, 1e-9);
  EXPECT_NEAR(frame.battery_sample.voltage, 16.8 - 0.03 * power / 16.8, 1e-9);
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(plant.step(true));
    suite.sample(plant, frame);
  }
  ASSERT_TRUE(frame.battery);
  const double open = 16.8 - 1e-3 * power * 1.0;
  EXPECT_NEAR(frame.battery_sample.voltage, open - 0.03 * power / open, 1e-6);
}

TEST(Sensing, AlterationsOfEffectsReachTheSamples) {
  Alteration a;
  a.change.mocap_offset = Vec3(0.01, 0, 0);
  a.change.mocap_clock_offset = 0.003;
  a.change.rotor_fault = 2;
  a.change.rotor_fault_scale = 0.1;
  a.change.rotor_fault_bias = 5;
  a.change.voltage_bias = -0.5;
  hang(
      {}, 10, 1,
      [&](const SensorFrame& f, double t) {
        if (f.mocap) {
          EXPECT_NEAR(f.mocap_sample.p_WB.x(), 0.01, 1e-15);
          EXPECT_NEAR(f.mocap_sample.t, t - 0.003, 1e-12);
        }
        if (f.rotor) {
          EXPECT_EQ(f.rotor_sample.speed[2], 5);
        }
        if (f.battery) {
          EXPECT_NEAR(f.battery_sample.voltage, 16.3, 1e-12);
        }
      },
      altered(a));
}

TEST(Sensing, StaleSamplesRepeatAtTheirRate) {
  Alteration a;
  a.change.stale_imu = 0.3;
  a.change.stale_mocap = 0.2;
  SensorConfig c;
  c.gyro_noise = 0.01;
  c.mocap_position_noise = 1e-3;
  int imu = 0, mocap = 0;
  Vec3 gyro = Vec3::Zero(), position = Vec3::Zero();
  hang(
      c, 20000, 9,
      [&](const SensorFrame& f, double) {
        imu += f.imu_sample.gyro_B == gyro;
        gyro = f.imu_sample.gyro_B;
        if (!f.mocap) return;
        mocap += f.mocap_sample.p_WB == position;
        position = f.mocap_sample.p_WB;
      },
      altered(a));
  EXPECT_NEAR(imu / 20000.0, 0.3, 0.02);
  EXPECT_NEAR(mocap / 5000.0, 0.2, 0.02);
}

TEST(Sensing, AnUnbalancedRotorShakesAtItsSpeed) {
  Alteration a;
  a.change.imbalance = 1e-6;
  Plant plant = make(omnimorph(), {}, {});
  for (std::size_t i = 0; i < 8; ++i) plant.seize_rotor(i, i == 0 ? 2 * kPi * 50 : 0.0);
  SensorSuite suite({}, altered(a), kStep, 1);
  SensorFrame frame;
  double cosine = 0, sine = 0;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(plant.step(true));
    suite.sample(plant, frame);
    const double x = frame.imu_sample.specific_force_B.x(), angle = 2 * kPi * 50 * plant.time();
    cosine += x * std::cos(angle) / 500, sine += x * std::sin(angle) / 500;
  }
  const double size = 1e-6 * std::pow(2 * kPi * 50, 2);
  EXPECT_NEAR(std::hypot(cosine, sine) / size, 1, 1e-6);
}

TEST(SensorFile, ShippedFilesLoadAndBadOnesAreRefused) {
  for (const char* name : {"ideal", "laboratory", "degraded"}) {
    auto yaml =
        files::YamlReader::load(std::string(OMNIFLIGHT_SOURCE_ROOT "/configs/sensors/") + name + ".yaml");
    ASSERT_TRUE(yaml) << name;
    yaml->ignore("schema");
    (void)read_sensor_config(*yaml);
    EXPECT_TRUE(yaml->finish()) << name << ": " << yaml->finish().error().text();
  }
  for (const char* text :
       {"mocap_dropout: 0.95", "gyro_noise_density_radps_per_sqrt_hz: -1", "board_clock_skew: 0.5",
        "imu_position_m: [0, 0]", "mocap_dropout_length_frames: 0", "gyro_filter: 3"}) {
    auto yaml = files::YamlReader::parse(text, "bad.yaml").value();
    (void)read_sensor_config(yaml);
    EXPECT_FALSE(yaml.finish()) << text;
  }
}

}  // namespace
}  // namespace omniflight::simulation
