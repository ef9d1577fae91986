#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(TiltOffset, IsWhatTheVehicleDoesAtTheOtherTilt) {
  for (const Situation& s : six_states()) {
    std::vector<double> speed;
    for (const RotorSituation& r : s.all_rotors()) speed.push_back(r.speed);
    for (const double offset : {0.035, -0.1}) {
      const Situation other = situation(cube(), s.body, s.alpha + offset, speed);
      const Vec6 expected = rotor_wrench(other) - rotor_wrench(s);
      EXPECT_LT((wrench_of("tilt_offset", s, {offset}) - expected).norm(), 1e-12);
    }
    EXPECT_EQ(wrench_of("tilt_offset", s, {0.0}).norm(), 0.0);
  }
}

TEST(TiltOffset, CostsVerticalThrustByTheCosineInHover) {
  const Situation s = hover(1.0, 0.5);
  const Vec6 w = wrench_of("tilt_offset", s, {0.04});
  EXPECT_NEAR(w[2] / rotor_wrench(s)[2], std::cos(0.54) / std::cos(0.5) - 1, 1e-12);
}

}  // namespace
}  // namespace omniflight::physics::testing
