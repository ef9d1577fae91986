// The step of a fit is the minimum inside its limits: no better point is beside it, and a step of nothing is
// never better.
#include "../src/bounded_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace omniflight::diagnosis {
namespace {

double value(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& d) {
  return 0.5 * d.dot(H * d) - g.dot(d);
}

/// The least value over every choice of what is held at which limit.
double least(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& low,
             const Eigen::VectorXd& high) {
  const auto m = static_cast<int>(g.size());
  double best = 0;
  for (int choice = 0; choice < static_cast<int>(std::pow(3, m)); ++choice) {
    Eigen::VectorXd d = Eigen::VectorXd::Zero(m);
    std::vector<Eigen::Index> open;
    for (int k = 0, rest = choice; k < m; ++k, rest /= 3)
      if (rest % 3 == 0)
        open.push_back(k);
      else
        d[k] = rest % 3 == 1 ? low[k] : high[k];
    if (!open.empty()) {
      const Eigen::VectorXd left = (g - H * d)(open), free = H(open, open).ldlt().solve(left);
      d(open) = free;
    }
    if (((d - low).array() < -1e-9).any() || ((d - high).array() > 1e-9).any()) continue;
    best = std::min(best, value(H, g, d));
  }
  return best;
}

TEST(BoundedStep, IsTheMinimumOfAllChoicesAlsoWhereColumnsHardlyDiffer) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int bound = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const double apart = std::pow(10.0, -(trial % 4));  // of the columns, in parts of their size
    Eigen::MatrixXd X = Eigen::MatrixXd::NullaryExpr(40, 5, [&] { return apart * normal(random); });
    const Eigen::VectorXd common = Eigen::VectorXd::NullaryExpr(40, [&] { return normal(random); });
    for (int k = 0; k < 4; ++k) X.col(k) += common;
    X.col(4) *= 1e4;  // another unit
    Eigen::MatrixXd H = X.transpose() * X;
    H.diagonal().array() += 1e-4;
    const Eigen::VectorXd g =
        X.transpose() * Eigen::VectorXd::NullaryExpr(40, [&] { return 3 * normal(random); });
    const Eigen::VectorXd high = Eigen::VectorXd::NullaryExpr(5, [&] { return std::abs(normal(random)); }),
                          low = -Eigen::VectorXd::NullaryExpr(5, [&] { return std::abs(normal(random)); });
    const Eigen::VectorXd d = bounded_step(H, g, low, high);
    EXPECT_TRUE((d.array() >= low.array() - 1e-12).all() && (d.array() <= high.array() + 1e-12).all());
    const double best = least(H, g, low, high);
    EXPECT_NEAR(value(H, g, d), best, 1e-6 * (1 + std::abs(best))) << "trial " << trial;
    bound += ((d - low).cwiseAbs().minCoeff() < 1e-9) || ((high - d).cwiseAbs().minCoeff() < 1e-9);
  }
  EXPECT_GT(bound, 100) << "most of these have a limit to meet";
}

TEST(BoundedStep, StartsAtALimitAndLeavesWhatDoesNothing) {
  Eigen::Matrix3d H = Eigen::Vector3d(4, 0, 1).asDiagonal();
  const Eigen::Vector3d d =
      bounded_step(H, Eigen::Vector3d(8, 1, -1), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(9, 1, 9));
  EXPECT_NEAR(d[0], 2, 1e-6);
  EXPECT_EQ(d[1], 0);
  EXPECT_EQ(d[2], 0) << "at its limit, and pushed against it";
}

}  // namespace
}  // namespace omniflight::diagnosis
