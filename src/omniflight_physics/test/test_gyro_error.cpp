#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(GyroError, IsABiasInBodyAxesAndBiasesAdd) {
  const double first[] = {0.01, -0.02, 0.03}, second[] = {0.04, 0.01, -0.05};
  Sensing s, expected;
  find_effect("gyro_error")->alter_sensing(first, s);
  expected.gyro_bias = Vec3(0.01, -0.02, 0.03);
  EXPECT_EQ(s, expected) << "nothing else of the sensors changes";
  find_effect("gyro_error")->alter_sensing(second, s);
  EXPECT_LT((s.gyro_bias - Vec3(0.05, -0.01, -0.02)).norm(), 1e-15);
  find_effect("gyro_error")->alter_sensing(neutral_of("gyro_error").data(), s);
  EXPECT_LT((s.gyro_bias - Vec3(0.05, -0.01, -0.02)).norm(), 1e-15);
}

}  // namespace
}  // namespace omniflight::physics::testing
