// The textbook methods find what they should on data made for them, and fail where the literature says they
// do.
#include <gtest/gtest.h>

#include <cmath>

#include "baseline_methods.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::proof {
namespace {

/// Three terms of one smooth column each; the residual is amount times the second, plus noise of a
/// correlation time.
BaselineData made(double amount, double noise_time, std::uint64_t seed) {
  BaselineData d;
  d.n = 2400;
  d.period = 0.025;
  Random random(seed);
  const char* ids[] = {"payload_mass", "rotor_drag", "com_offset"};
  for (int k = 0; k < 3; ++k) {
    Eigen::MatrixXd c(d.n, 6);
    for (int channel = 0; channel < 6; ++channel) {
      const double f = random.uniform(0.05, 0.9), phase = random.uniform(0, 6.28),
                   g = random.uniform(0.05, 0.9);
      for (int i = 0; i < d.n; ++i)
        c(i, channel) = std::sin(6.28 * f * i * d.period + phase) + std::sin(6.28 * g * i * d.period);
    }
    d.columns.push_back(c);
    d.terms.push_back({ids[k], "wrench", {"value"}, k});
  }
  const double keep = noise_time > 0 ? std::exp(-d.period / noise_time) : 0;
  d.residual = amount * d.columns[1];
  for (int channel = 0; channel < 6; ++channel) {
    double e = 0;
    for (int i = 0; i < d.n; ++i) {
      e = keep * e + std::sqrt(1 - keep * keep) * random.normal();
      d.residual(i, channel) += e;
    }
  }
  d.features = Eigen::MatrixXd::Zero(d.n, 2);
  for (int i = 0; i < d.n; ++i) d.features.row(i) << d.columns[1](i, 0), std::sin(0.01 * i);
  return d;
}

TEST(Baselines, NameWhatIsThere) {
  const auto d = made(0.5, 0, 1);
  for (const auto& a : {least_squares(d), thresholded(d), stepwise(d, false), stepwise(d, true)}) {
    ASSERT_FALSE(a.terms.empty());
    EXPECT_EQ(a.terms[0].id, "rotor_drag");
    EXPECT_NEAR(a.terms[0].values[0], 0.5, 0.05);
  }
}

TEST(Baselines, AreQuietOnWhiteNoise) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto d = made(0, 0, seed);
    alarms += !stepwise(d, true).terms.empty();
    alarms += !stepwise(d, false).terms.empty();
  }
  EXPECT_LE(alarms, 4);
}

TEST(Baselines, OrdinaryTestsFireOnColouredNoiseAndWhiteningCures) {
  int ordinary = 0, white = 0, whitened = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto d = made(0, 0.3, seed);
    ordinary += !least_squares(d).terms.empty();
    white += !stepwise(d, false).terms.empty();
    whitened += !stepwise(d, true).terms.empty();
  }
  EXPECT_GE(ordinary, 10);
  EXPECT_GE(white, 10);
  EXPECT_LE(whitened, 4);
}

TEST(Baselines, ABlackBoxSeesButDoesNotName) {
  auto d = made(0, 0, 1);
  for (int i = 0; i < d.n; ++i) d.residual(i, 0) += std::abs(d.features(i, 0));
  const auto a = black_box(d);
  EXPECT_TRUE(a.mismatch);
  EXPECT_TRUE(a.terms.empty());
}

}  // namespace
}  // namespace omniflight::proof
