#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "slung_load";
const Vec3 kAt(0.05, -0.02, -0.1);  // m, attachment

std::vector<double> theta(double damping) { return {0.3, 0.8, damping, kAt.x(), kAt.y(), kAt.z()}; }

/// Six states at which the vehicle neither accelerates nor turns.
std::vector<Situation> steady_states() {
  std::vector<Situation> out = six_states();
  for (Situation& s : out) {
    s.a_WB_B.setZero();
    s.dw_WB_B.setZero();
    s.body.w_WB_B.setZero();
  }
  return out;
}

/// Energy [J] of the load about a vehicle at rest: m (L^2 |dq|^2 / 2 + g L q_z).
double energy(const std::vector<double>& x) {
  return 0.3 * (0.5 * 0.64 * Vec3(x[3], x[4], x[5]).squaredNorm() + kGravity * 0.8 * x[2]);
}

TEST(SlungLoad, DampingTakesEnergyFromTheSwingInEveryFrame) {
  const Vec3 q = Vec3(0.3, -0.4, -1).normalized(), dq = q.cross(Vec3(0.5, 1.0, -0.7));
  const std::vector<double> x{q.x(), q.y(), q.z(), dq.x(), dq.y(), dq.z(), 1};
  for (const Situation& s : steady_states())
    for (const double c : {0.0, 0.2, 1.5}) {
      const std::vector<double> rate = rate_of(kId, s, theta(c), x);
      const Vec3 ddq(rate[3], rate[4], rate[5]);
      const double gained = 0.3 * (0.64 * dq.dot(ddq) + kGravity * 0.8 * rate[2]);
      EXPECT_NEAR(gained, -c * 0.3 * 0.64 * dq.squaredNorm(), 1e-12);
    }
}

TEST(SlungLoad, TheCableItselfNeitherTakesNorGivesEnergy) {
  // what the vehicle gives at its attachment, the undamped load has, in any motion of both
  const Vec3 q = Vec3(0.3, -0.4, -1).normalized(), dq = q.cross(Vec3(0.5, 1.0, -0.7));
  const std::vector<double> x{q.x(), q.y(), q.z(), dq.x(), dq.y(), dq.z(), 1};
  for (const Situation& s : six_states()) {
    const std::vector<double> rate = rate_of(kId, s, theta(0), x);
    const Vec3 &w = s.body.w_WB_B, ddq(rate[3], rate[4], rate[5]);
    const Vec3 v = s.body.v_WB_W + s.R_WB * w.cross(kAt) + 0.8 * dq;
    const Vec3 a = s.R_WB * (s.a_WB_B + s.dw_WB_B.cross(kAt) + w.cross(w.cross(kAt))) + 0.8 * ddq;
    const double gained = 0.3 * v.dot(a + Vec3(0, 0, kGravity));
    EXPECT_NEAR(power(s, remembered(kId, s, theta(0), x)), -gained, 1e-12);
  }
}

TEST(SlungLoad, FrictionInTheJointActsOnBothAndTakesEnergyFromThemTogether) {
  const double mass = 0.3, length = 0.8, c = 1.5;
  for (const bool caught : {false, true}) {
    const Vec3 n = Vec3(0.3, -0.4, -1).normalized(), q = (caught ? 1.01 : 1.0) * n,
               dq = q.cross(Vec3(0.5, 1.0, -0.7)) + (caught ? 0.2 : 0.0) * n;
    const std::vector<double> x{q.x(), q.y(), q.z(), dq.x(), dq.y(), dq.z(), 1};
    for (const Situation& s : six_states()) {
      const auto rubbing = rate_of(kId, s, theta(c), x), free = rate_of(kId, s, theta(0), x);
      const Vec3 on_load =
          mass * length * Vec3(rubbing[3] - free[3], rubbing[4] - free[4], rubbing[5] - free[5]);
      const Vec6 on_body = remembered(kId, s, theta(c), x) - remembered(kId, s, theta(0), x);
      EXPECT_GT(on_load.norm(), 0.05);
      EXPECT_LT((s.R_WB * on_body.head<3>() + on_load).norm(), 1e-12) << "force";
      const Vec3 at = kAt + s.R_WB.transpose() * (length * q);
      EXPECT_LT((on_body.tail<3>() + at.cross(s.R_WB.transpose() * on_load)).norm(), 1e-12) << "torque";
      const Vec3 v_load = s.body.v_WB_W + s.R_WB * s.body.w_WB_B.cross(kAt) + length * dq;
      const Vec3 turns = dq - n.dot(dq) * n - (s.R_WB * s.body.w_WB_B).cross(q);
      EXPECT_NEAR(power(s, on_body) + on_load.dot(v_load), -mass * c * length * length * turns.squaredNorm(),
                  1e-12)
          << "energy";
    }
  }
}

TEST(SlungLoad, TurningWithTheVehicleItDoesNotRub) {
  for (const Situation& s : six_states()) {
    const Vec3 q = Vec3(0.3, -0.4, -1).normalized(), dq = (s.R_WB * s.body.w_WB_B).cross(q);
    const std::vector<double> x{q.x(), q.y(), q.z(), dq.x(), dq.y(), dq.z(), 1};
    EXPECT_LT((remembered(kId, s, theta(1.5), x) - remembered(kId, s, theta(0), x)).norm(), 1e-12);
  }
}

TEST(SlungLoad, ASwingKeepsItsEnergyWithoutDampingAndOnlyLosesWithIt) {
  const Situation s = hover(2.0);
  const Effect* load = find_effect(kId);
  Random random(1);
  for (const double c : {0.0, 0.4}) {
    const std::vector<double> p = theta(c);
    std::vector<double> x{std::sin(0.9), 0, -std::cos(0.9), 0, 0.6, 0, 1};
    const double lowest = -0.3 * kGravity * 0.8, start = energy(x) - lowest, h = 0.001;
    const auto moved = [&](const std::vector<double>& from, const std::vector<double>& rate, double dt) {
      std::vector<double> out = from;
      for (std::size_t k = 0; k < 6; ++k) out[k] += dt * rate[k];
      return out;
    };
    double last = start;
    for (int k = 0; k < 5000; ++k) {  // Runge-Kutta of fourth order
      const auto k1 = rate_of(kId, s, p, x), k2 = rate_of(kId, s, p, moved(x, k1, h / 2)),
                 k3 = rate_of(kId, s, p, moved(x, k2, h / 2)), k4 = rate_of(kId, s, p, moved(x, k3, h));
      for (std::size_t i = 0; i < 6; ++i) x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
      load->advance(s, p.data(), h, random, x.data());
      ASSERT_EQ(x[6], 1.0) << "taut all along";
      const double now = energy(x) - lowest;
      if (c > 0) {
        ASSERT_LT(now, last);
      }
      last = now;
    }
    if (c == 0)
      EXPECT_NEAR(last, start, 1e-9);
    else
      EXPECT_GT(last, std::exp(-2 * 0.4 * 5.0) * start) << "no faster than all of it in motion";
  }
}

// A wide swing replayed at the rate of a recording: the tension follows from the direction by the energy.
TEST(SlungLoad, AtTheRateOfARecordingTheTensionIsThatOfTheSwing) {
  const double widest = 1.0, mass = 0.3;
  const std::vector<Situation> motion(240, hover(2.0));
  const std::vector<double> p = theta(0), offset{std::sin(widest), 0, 1 - std::cos(widest), 0, 0, 0};
  std::vector<double> wrench(6 * motion.size());
  find_effect(kId)->replay_from(motion, 0.025, p.data(), offset.data(), wrench.data());
  double least = 1e9, most = 0;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const Vec3 pull(wrench[6 * i], wrench[6 * i + 1], wrench[6 * i + 2]);
    const double tension = mass * kGravity * (3 * -pull.normalized().z() - 2 * std::cos(widest));
    EXPECT_NEAR(pull.norm(), tension, 0.05 * mass * kGravity) << "sample " << i;
    least = std::min(least, pull.norm());
    most = std::max(most, pull.norm());
  }
  EXPECT_LT(least, 0.6 * mass * kGravity);
  EXPECT_GT(most, 1.8 * mass * kGravity);
}

}  // namespace
}  // namespace omniflight::physics::testing
