// A tilt that lags behind what its servo reports.
#include "../src/search/hidden_tilt.hpp"

#include <gtest/gtest.h>

#include "../src/search/single_rotor.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

TEST(HiddenTilt, ARampIsAnOffsetByRateTimesLagAndRestIsNothing) {
  const vehicle::Vehicle v = test::omnimorph();
  const std::vector<double> speeds{500, 510, 520, 530, 540, 550, 560, 570};
  constexpr double kLag = 0.08, kRate = 0.3, kPeriod = 0.0125;  // s, rad/s, s
  std::vector<physics::Situation> ramp(200), rest(200);
  RigidState x;
  x.p_WB.z() = 1;
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    physics::prepare(v, x, 0.2 + kRate * kPeriod * static_cast<double>(i), speeds, {}, {}, ramp[i]);
    physics::prepare(v, x, 0.5, speeds, {}, {}, rest[i]);
  }
  const physics::Effect& lag = hidden_tilt_lag();
  ASSERT_EQ(lag.parameter_count(), 1);
  std::vector<double> w(6 * ramp.size()), j(6 * ramp.size());
  lag.replay(rest, kPeriod, &kLag, w.data(), j.data());
  for (const double at_rest : w) EXPECT_EQ(at_rest, 0.0);
  lag.replay(ramp, kPeriod, &kLag, w.data(), j.data());
  const double behind = -kRate * kLag;
  std::array<double, 6> offset{};
  std::array<double, 6 * physics::kMaxParameters> unused{};
  physics::find_effect("tilt_offset")
      ->wrench_with_jacobian(ramp.back(), &behind, offset.data(), unused.data());
  double size = 0;
  for (std::size_t c = 0; c < 6; ++c) size = std::max(size, std::abs(offset[c]));
  EXPECT_GT(size, 0.01);
  for (std::size_t c = 0; c < 6; ++c) EXPECT_NEAR(w[w.size() - 6 + c], offset[c], 0.01 * size);
}

TEST(HiddenTilt, IsOfferedBesideAnOffsetAndReportedAsALagOfTheServo) {
  const vehicle::Vehicle v = test::omnimorph();
  const auto offered = by_rotor({physics::find_effect("tilt_offset")}, v);
  ASSERT_EQ(offered.size(), 2u);
  EXPECT_EQ(offered[1], &hidden_tilt_lag());
  const physics::ActiveEffect whole = in_full({&hidden_tilt_lag(), {0.07}});
  EXPECT_EQ(whole.effect->info().id, "tilt_servo_lag");
  ASSERT_EQ(static_cast<int>(whole.theta.size()), whole.effect->parameter_count());
  EXPECT_EQ(whole.theta[0], 0.07);
}

}  // namespace
}  // namespace omniflight::diagnosis
