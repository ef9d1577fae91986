#include <gtest/gtest.h>

#include <cmath>

#include "../src/numerics/statistics.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis {
namespace {

Eigen::VectorXd sine(double hz, double rate, int n) {
  Eigen::VectorXd x(n);
  for (int i = 0; i < n; ++i) x[i] = std::sin(2 * kPi * hz * i / rate);
  return x;
}

TEST(Filter, PassesSlowSignalsWithoutDelayAndStopsFastOnes) {
  const Eigen::VectorXd slow = sine(2, 200, 1000), fast = sine(60, 200, 1000);
  EXPECT_LT((low_pass(slow, 200, 15) - slow).middleRows(100, 800).cwiseAbs().maxCoeff(), 0.002);
  EXPECT_LT(low_pass(fast, 200, 15).block(100, 0, 800, 1).cwiseAbs().maxCoeff(), 0.001);
  EXPECT_NEAR(low_pass(Eigen::VectorXd::Constant(50, 3.0), 200, 15)(25, 0), 3.0, 1e-9);
}

TEST(Filter, DifferentiatesASineToItsCosine) {
  const Eigen::MatrixXd d = differentiate(sine(1, 500, 1000), 500);
  EXPECT_NEAR(d(500, 0), 2 * kPi * std::cos(2 * kPi * 500 / 500.0), 1e-3);
}

TEST(Statistics, ChiSquaredTailMatchesTables) {
  EXPECT_NEAR(chi_squared_tail(3.841, 1), 0.05, 1e-4);
  EXPECT_NEAR(chi_squared_tail(18.307, 10), 0.05, 1e-4);
  EXPECT_NEAR(chi_squared_tail(29.588, 10), 0.001, 1e-5);
}

TEST(Statistics, ChiSquaredQuantileIsTheInverseOfItsTail) {
  EXPECT_NEAR(chi_squared_quantile(0.05, 1), 3.8415, 1e-3);
  EXPECT_NEAR(chi_squared_quantile(0.001, 10), 29.588, 1e-3);
  for (const double p : {0.9, 0.1, 1e-4, 1e-8})
    for (const int k : {1, 3, 16}) EXPECT_NEAR(chi_squared_tail(chi_squared_quantile(p, k), k) / p, 1, 1e-6);
}

}  // namespace
}  // namespace omniflight::diagnosis
