// A tilt that lags behind what its servo reports.
#include "effect_testing.hpp"
#include "omniflight_physics/actuators.hpp"

namespace omniflight::physics::testing {
namespace {

TEST(TiltServoLag, UnrecordedOnARampIsAnOffsetByRateTimesLagAndAtRestIsNothing) {
  const Effect* lag = find_effect("tilt_servo_lag")->unrecorded_form();
  ASSERT_NE(lag, nullptr);
  ASSERT_EQ(lag->parameter_count(), 1);
  const std::vector<double> speeds{500, 510, 520, 530, 540, 550, 560, 570};
  constexpr double kLag = 0.08, kRate = 0.3, kPeriod = 0.0125;  // s, rad/s, s
  RigidState body;
  body.p_WB.z() = 1;
  std::vector<Situation> ramp, rest;
  for (int i = 0; i < 200; ++i) {
    ramp.push_back(situation(cube(), body, 0.2 + kRate * kPeriod * i, speeds));
    rest.push_back(situation(cube(), body, 0.5, speeds));
  }
  std::vector<double> w(6 * ramp.size()), j(6 * ramp.size());
  lag->replay(rest, kPeriod, &kLag, w.data(), j.data());
  for (const double at_rest : w) EXPECT_EQ(at_rest, 0.0);
  lag->replay(ramp, kPeriod, &kLag, w.data(), j.data());
  const Vec6 offset = wrench_of("tilt_offset", ramp.back(), {-kRate * kLag});
  const double size = offset.cwiseAbs().maxCoeff();
  EXPECT_GT(size, 0.01);
  for (std::size_t c = 0; c < 6; ++c)
    EXPECT_NEAR(w[w.size() - 6 + c], offset[static_cast<Eigen::Index>(c)], 0.01 * size);
}

TEST(TiltServoLag, UnrecordedStandsForTheLagWithoutPlay) {
  const std::vector<double> whole = find_effect("tilt_servo_lag")->from_unrecorded_form({0.07});
  EXPECT_EQ(whole, (std::vector<double>{0.07, 0.0}));
}

TEST(TiltServoLag, AddsToWhatTheVehicleFileTells) {
  vehicle::Vehicle told = cube();
  told.tilt = {vehicle::TiltKind::common, 0, 1, 0, 0.08, 0.01};
  Actuation a = nominal_actuation(told);
  EXPECT_EQ(a.tilt_time_constant, 0.08);
  EXPECT_EQ(a.tilt_backlash, 0.01);
  const std::vector<double> hidden{0.06, 0.02};
  find_effect("tilt_servo_lag")->alter_actuation(told, hidden.data(), a);
  EXPECT_DOUBLE_EQ(a.tilt_time_constant, 0.14);
  EXPECT_DOUBLE_EQ(a.tilt_backlash, 0.03);
}

}  // namespace
}  // namespace omniflight::physics::testing
