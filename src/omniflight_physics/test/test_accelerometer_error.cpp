#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(AccelerometerError, IsABiasInBodyAxesAndBiasesAdd) {
  const double first[] = {0.05, -0.1, 0.2}, second[] = {0.01, 0.02, -0.3};
  Sensing s, expected;
  find_effect("accelerometer_error")->alter_sensing(first, s);
  expected.accelerometer_bias = Vec3(0.05, -0.1, 0.2);
  EXPECT_EQ(s, expected) << "nothing else of the sensors changes";
  find_effect("accelerometer_error")->alter_sensing(second, s);
  EXPECT_LT((s.accelerometer_bias - Vec3(0.06, -0.08, -0.1)).norm(), 1e-15);
  find_effect("accelerometer_error")->alter_sensing(neutral_of("accelerometer_error").data(), s);
  EXPECT_LT((s.accelerometer_bias - Vec3(0.06, -0.08, -0.1)).norm(), 1e-15);
}

}  // namespace
}  // namespace omniflight::physics::testing
