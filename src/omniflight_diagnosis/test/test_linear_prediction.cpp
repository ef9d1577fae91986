#include "../src/regression/linear_prediction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace omniflight::diagnosis {
namespace {

constexpr int kBlock = 25, kApart = 8;

Eigen::MatrixXd white(int rows, int cols, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  return x.dot(y) / std::max(1e-12, x.norm() * y.norm());
}

TEST(LinearPrediction, ManyRegressorsThatKnowNothingPredictNoNoise) {
  const Eigen::MatrixXd known = white(600, 120, 1), target = white(600, 1, 2);
  const Eigen::MatrixXd fitted = known * known.colPivHouseholderQr().solve(target);
  const Eigen::MatrixXd predicted = predict_linearly(known, target, kBlock, kApart);
  EXPECT_GT(correlation(fitted, target), 0.35) << "least squares fits the noise of its own sample";
  EXPECT_LT(correlation(predicted, target), 0.1);
  EXPECT_LT(predicted.squaredNorm(), 0.1 * target.squaredNorm());
}

TEST(LinearPrediction, WhatIsKnownIsPredicted) {
  const Eigen::MatrixXd known = white(600, 20, 3), map = white(20, 2, 4), noise = 0.1 * white(600, 2, 5);
  const Eigen::MatrixXd clean = known * map;
  const Eigen::MatrixXd predicted = predict_linearly(known, clean + noise, kBlock, kApart);
  EXPECT_LT((predicted - clean).norm(), 0.03 * clean.norm());
}

TEST(LinearPrediction, AFlightThatNeverRepeatsIsPredictedByItsNeighbourhood) {
  // the relation drifts with height, and no height is flown twice
  const int n = 3000;
  const Eigen::MatrixXd state = white(n, 1, 6);
  Eigen::MatrixXd known(n, 5), target(n, 1);
  for (int i = 0; i < n; ++i) {
    const double height = 2.0 * i / n;
    known.row(i) << height, height * height, std::pow(height, 3), state(i, 0), height * state(i, 0);
    target(i, 0) = std::cos(2 * height) + (1 + height) * state(i, 0);
  }
  const Eigen::MatrixXd predicted = predict_linearly(known, target, kBlock, kApart);
  EXPECT_GT(correlation(predicted, target), 0.99);
}

TEST(LinearPrediction, AStretchTooShortToTellIsPredictedByItsMean) {
  const Eigen::MatrixXd known = white(9, 30, 7), target = white(9, 1, 8);
  const Eigen::MatrixXd predicted = predict_linearly(known, target, kBlock, kApart);
  EXPECT_NEAR((predicted.array() - target.mean()).abs().maxCoeff(), 0, 1e-9);
}

}  // namespace
}  // namespace omniflight::diagnosis
