#include <gtest/gtest.h>

#include "../src/evidence/inner_products.hpp"

namespace omniflight::diagnosis {
namespace {

TEST(InnerProducts, AreThoseOfTheColumns) {
  const Eigen::MatrixXf a = Eigen::MatrixXf::Random(333, 7), b = Eigen::MatrixXf::Random(333, 1100);
  const Eigen::MatrixXf expected = (a.cast<double>().transpose() * b.cast<double>()).cast<float>();
  for (const int threads : {1, 2})
    EXPECT_LT((inner_products(a, b, threads) - expected).cwiseAbs().maxCoeff(), 1e-3f) << threads;
  EXPECT_LT((inner_products(b.middleCols(5, 3), b, 1) -
             (b.middleCols(5, 3).cast<double>().transpose() * b.cast<double>()).cast<float>())
                .cwiseAbs()
                .maxCoeff(),
            1e-3f)
      << "columns of a larger matrix";
}

TEST(InnerProducts, NothingInNothingOut) {
  EXPECT_EQ(inner_products(Eigen::MatrixXf(4, 0), Eigen::MatrixXf(4, 3)).size(), 0);
  EXPECT_TRUE(inner_products(Eigen::MatrixXf(0, 2), Eigen::MatrixXf(0, 3)).isZero(0));
}

}  // namespace
}  // namespace omniflight::diagnosis
