#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "rotor_inertia";

/// Six states whose rotors also speed up and slow down.
std::vector<Situation> changing_speeds() {
  std::vector<Situation> out = six_states();
  for (Situation& s : out)
    for (std::size_t i = 0; i < 8; ++i) s.rotors[i].acceleration = 400.0 - 130.0 * static_cast<double>(i);
  return out;
}

/// Angular momentum [Nms] of the rotors in the world per J_r: spin +1 gets the torque of its drag on the body
/// along n, so it turns about -n.
Vec3 momentum(const Situation& s, bool rate_of_speed = false) {
  Vec3 h = Vec3::Zero();
  for (const RotorSituation& r : s.all_rotors())
    h -= s.R_WB * (r.spin * (rate_of_speed ? r.acceleration : r.speed) * r.n_B);
  return h;
}

TEST(RotorInertia, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : changing_speeds()) {
    const Vec3 w = s.R_WB * s.body.w_WB_B;
    const Vec3 rate = momentum(s, true) + w.cross(momentum(s));  // dh/dt in the world
    Vec6 expected;
    expected << Vec3::Zero(), s.R_WB.transpose() * (-3e-5 * rate);
    EXPECT_GT(expected.norm(), 1e-3);
    EXPECT_LT((wrench_of(kId, s, {3e-5}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(RotorInertia, ARotorThatSpeedsUpPushesTheBodyTheWayItsDragDoes) {
  for (const double spin : {1.0, -1.0}) {
    Situation s = hover(1.0);
    for (auto& r : s.rotors)
      if (r.spin == spin) r.acceleration = 500;
    const double start_up = wrench_of(kId, s, {2e-5})[5];
    EXPECT_NEAR(start_up, spin * 4 * 2e-5 * 500, 1e-15);
    for (auto& r : s.rotors)
      if (r.spin != spin) r.speed = r.thrust = 0;
    EXPECT_GT(start_up * rotor_wrench(s)[5], 0.0);
  }
}

TEST(RotorInertia, ThePartOfTheGyroscopeDoesNoWork) {
  for (const Situation& s : six_states()) {  // constant speeds
    const Vec6 w = wrench_of(kId, s, {2e-5});
    EXPECT_GT(w.norm(), 1e-4);
    EXPECT_NEAR(power(s, w), 0.0, 1e-15);
  }
}

}  // namespace
}  // namespace omniflight::physics::testing
