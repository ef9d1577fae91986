#include "linear_prediction.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace omniflight::diagnosis {
namespace {

/// Added to the diagonal, over the variance of a regressor: from what keeps collinear ones solvable.
constexpr std::array<double, 6> kRidges{1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 1};
constexpr Eigen::Index kFolds = 5;  ///< each leaves out a fifth, and what is close to it

Eigen::MatrixXd standardised(const Eigen::MatrixXd& known) {
  Eigen::MatrixXd X = known.rowwise() - known.colwise().mean();
  for (Eigen::Index k = 0; k < X.cols(); ++k) {
    const double deviation = std::sqrt(X.col(k).squaredNorm() / static_cast<double>(X.rows()));
    X.col(k) *= deviation > 0 ? 1 / deviation : 0.0;
  }
  return X;
}

}  // namespace

Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int block,
                                 int apart) {
  const Eigen::Index n = known.rows();
  const Eigen::RowVectorXd mean = targets.colwise().mean();
  block = static_cast<int>(std::max<Eigen::Index>(apart / 2 + 1, std::min<Eigen::Index>(block, n / kFolds)));
  const Eigen::MatrixXd X = standardised(known), Y = targets.rowwise() - mean;
  const Eigen::MatrixXd H = X.transpose() * X, moments = X.transpose() * Y;
  std::array<Eigen::MatrixXd, kRidges.size()> predicted;
  predicted.fill(Eigen::MatrixXd(n, Y.cols()));
  for (Eigen::Index fold = 0; fold < kFolds; ++fold) {
    Eigen::MatrixXd others = H, rest = moments;
    const auto each_block = [&](const auto& visit) {
      for (Eigen::Index begin = fold * block; begin < n; begin += kFolds * block)
        visit(begin, std::min<Eigen::Index>(n, begin + block));
    };
    each_block([&](Eigen::Index begin, Eigen::Index end) {
      const Eigen::Index from = std::max<Eigen::Index>(0, begin - apart);
      const Eigen::Index left_out = std::min<Eigen::Index>(n, end + apart) - from;
      const auto x = X.middleRows(from, left_out);
      others.noalias() -= x.transpose() * x;
      rest.noalias() -= x.transpose() * Y.middleRows(from, left_out);
    });
    for (std::size_t k = 0; k < kRidges.size(); ++k) {
      Eigen::MatrixXd ridged = others;
      ridged.diagonal().array() += kRidges[k] * static_cast<double>(n);
      const Eigen::MatrixXd coefficients = ridged.llt().solve(rest);
      each_block([&](Eigen::Index begin, Eigen::Index end) {
        predicted[k].middleRows(begin, end - begin) = X.middleRows(begin, end - begin) * coefficients;
      });
    }
  }
  Eigen::MatrixXd out(n, Y.cols());
  for (Eigen::Index c = 0; c < Y.cols(); ++c) {
    const auto missed = [&](const Eigen::MatrixXd& p) { return (p.col(c) - Y.col(c)).squaredNorm(); };
    const auto best = std::min_element(
        predicted.begin(), predicted.end(),
        [&](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return missed(a) < missed(b); });
    const double power = best->col(c).squaredNorm();
    // what is predicted small by shrinkage would make a coefficient on it as much too large
    const double slope = power > 0 ? std::max(0.0, best->col(c).dot(Y.col(c)) / power) : 0.0;
    out.col(c) = slope * best->col(c).array() + mean[c];
  }
  return out;
}

}  // namespace omniflight::diagnosis
