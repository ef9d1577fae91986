#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(MocapTilt, LeansAboutTheHorizontalAxesOnly) {
  const double first[] = {0.004, -0.007}, second[] = {0.001, 0.002};
  Sensing s, expected;
  find_effect("mocap_tilt")->alter_sensing(first, s);
  expected.mocap_tilt = Vec3(0.004, -0.007, 0);
  EXPECT_EQ(s, expected) << "nothing else of the sensors changes";
  find_effect("mocap_tilt")->alter_sensing(second, s);
  EXPECT_LT((s.mocap_tilt - Vec3(0.005, -0.005, 0)).norm(), 1e-15);
  find_effect("mocap_tilt")->alter_sensing(neutral_of("mocap_tilt").data(), s);
  EXPECT_LT((s.mocap_tilt - Vec3(0.005, -0.005, 0)).norm(), 1e-15);
}

}  // namespace
}  // namespace omniflight::physics::testing
