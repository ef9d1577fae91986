#include "../src/evidence/cosine_transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace omniflight::diagnosis {
namespace {

TEST(CosineTransform, LengthsHaveSmallPrimeFactorsOnly) {
  EXPECT_EQ(transform_length(1), 1);
  EXPECT_EQ(transform_length(7), 6);
  EXPECT_EQ(transform_length(2400), 2400);
  for (const int n : {7, 11, 97, 1001, 2399}) {
    int left = transform_length(n);
    EXPECT_LE(left, n);
    EXPECT_GT(left, 3 * n / 4);
    for (const int prime : {2, 3, 5})
      while (left % prime == 0) left /= prime;
    EXPECT_EQ(left, 1);
  }
}

TEST(CosineTransform, IsTheDefinitionAndKeepsLengths) {
  for (const int n : {1, 2, 5, 8, 15, 30}) {
    CosineTransform transform(n);
    Eigen::VectorXd x(n);
    for (int i = 0; i < n; ++i) x[i] = std::sin(1.7 * i) + 0.3 * i;
    Eigen::VectorXd y = x;
    transform.apply(y);
    for (int k = 0; k < n; ++k) {
      double sum = 0;
      for (int i = 0; i < n; ++i) sum += x[i] * std::cos(std::numbers::pi * k * (i + 0.5) / n);
      EXPECT_NEAR(y[k], sum * std::sqrt((k == 0 ? 1.0 : 2.0) / n), 1e-10) << n << ' ' << k;
    }
    EXPECT_NEAR(x.norm(), y.norm(), 1e-10);
    transform.invert(y);
    EXPECT_LT((y - x).norm(), 1e-10 * x.norm() + 1e-12) << n;
  }
}

TEST(CosineTransform, TwoAtOnceAreAsEachAlone) {
  for (const int n : {1, 2, 5, 8, 15, 30}) {
    CosineTransform transform(n);
    Eigen::VectorXd x(n), y(n);
    for (int i = 0; i < n; ++i) {
      x[i] = std::sin(1.7 * i) + 0.3 * i;
      y[i] = 100 * std::cos(0.9 * i);
    }
    Eigen::VectorXd together_x = x, together_y = y;
    transform.apply(together_x, together_y);
    transform.apply(x);
    transform.apply(y);
    EXPECT_LT((together_x - x).norm(), 1e-13 * (x.norm() + y.norm())) << n;
    EXPECT_LT((together_y - y).norm(), 1e-13 * (x.norm() + y.norm())) << n;
  }
}

}  // namespace
}  // namespace omniflight::diagnosis
