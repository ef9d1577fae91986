#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../src/conditioning/outliers.hpp"

namespace omniflight::diagnosis {
namespace {

recording::Signal noisy(double outlier_share, std::vector<Eigen::Index>& outliers) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  recording::Signal s;
  s.name = "position";
  s.unit = "m";
  s.values.resize(4000, 1);
  for (Eigen::Index i = 0; i < 4000; ++i) {
    const double t = 0.01 * static_cast<double>(i);
    s.t_s.push_back(t);
    s.values(i, 0) = std::sin(2 * t) + (i > 2000 ? 0.5 : 0.0) + 1e-3 * normal(random);
    if (uniform(random) < outlier_share && i > 2 && (outliers.empty() || i > outliers.back() + 4)) {
      s.values(i, 0) += 0.02;
      outliers.push_back(i);
    }
  }
  return s;
}

TEST(Outliers, LoneOnesAreReplacedByTheirNeighbours) {
  std::vector<Eigen::Index> outliers;
  const recording::Signal s = noisy(0.01, outliers);
  ASSERT_GT(outliers.size(), 20U);
  const recording::Signal out = without_outliers(s);
  for (const Eigen::Index i : outliers)
    EXPECT_NEAR(out.values(i, 0), std::sin(0.02 * static_cast<double>(i)) + (i > 2000 ? 0.5 : 0.0), 5e-3)
        << i;
}

TEST(Outliers, NoiseMotionAndStepsStay) {
  std::vector<Eigen::Index> none;
  const recording::Signal s = noisy(0, none);
  const recording::Signal out = without_outliers(s);
  EXPECT_LT((out.values - s.values).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Outliers, AShortOrHeldSignalStays) {
  recording::Signal s;
  s.values.resize(300, 1);
  for (int i = 0; i < 300; ++i) {
    s.t_s.push_back(0.01 * i);
    s.values(i, 0) = i / 50;  // held for fifty samples each
  }
  EXPECT_EQ(without_outliers(s).values, s.values);
}

}  // namespace
}  // namespace omniflight::diagnosis
