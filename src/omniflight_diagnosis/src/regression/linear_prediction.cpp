#include "linear_prediction.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace omniflight::diagnosis {
namespace {

/// Added to the diagonal, over the variance of a regressor: from what keeps collinear ones solvable.
constexpr std::array<double, 6> kRidges{1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 1};
constexpr Eigen::Index kMostBlocks = 10, kLeastBlock = 16;

Eigen::MatrixXd standardised(const Eigen::MatrixXd& known) {
  Eigen::MatrixXd X = known.rowwise() - known.colwise().mean();
  for (Eigen::Index k = 0; k < X.cols(); ++k) {
    const double deviation = std::sqrt(X.col(k).squaredNorm() / static_cast<double>(X.rows()));
    X.col(k) *= deviation > 0 ? 1 / deviation : 0.0;
  }
  return X;
}

}  // namespace

Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int apart) {
  const Eigen::Index n = known.rows(), blocks = std::clamp<Eigen::Index>(n / kLeastBlock, 1, kMostBlocks);
  const Eigen::RowVectorXd mean = targets.colwise().mean();
  if (blocks < 2) return mean.replicate(n, 1);  // too short to tell
  const Eigen::MatrixXd X = standardised(known), Y = targets.rowwise() - mean;
  const Eigen::MatrixXd H = X.transpose() * X, moments = X.transpose() * Y;
  std::array<Eigen::MatrixXd, kRidges.size()> predicted;
  predicted.fill(Eigen::MatrixXd(n, Y.cols()));
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index begin = b * n / blocks, end = (b + 1) * n / blocks;
    const Eigen::Index from = std::max<Eigen::Index>(0, begin - apart);
    const Eigen::Index left_out = std::min<Eigen::Index>(n, end + apart) - from;
    const auto x = X.middleRows(from, left_out);
    const Eigen::MatrixXd others = H - x.transpose() * x;
    const Eigen::MatrixXd rest = moments - x.transpose() * Y.middleRows(from, left_out);
    for (std::size_t k = 0; k < kRidges.size(); ++k) {
      Eigen::MatrixXd ridged = others;
      ridged.diagonal().array() += kRidges[k] * static_cast<double>(n);
      predicted[k].middleRows(begin, end - begin) =
          X.middleRows(begin, end - begin) * ridged.llt().solve(rest);
    }
  }
  Eigen::MatrixXd out(n, Y.cols());
  for (Eigen::Index c = 0; c < Y.cols(); ++c) {
    const auto missed = [&](const Eigen::MatrixXd& p) { return (p.col(c) - Y.col(c)).squaredNorm(); };
    const auto best = std::min_element(
        predicted.begin(), predicted.end(),
        [&](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return missed(a) < missed(b); });
    out.col(c) = best->col(c).array() + mean[c];
  }
  return out;
}

}  // namespace omniflight::diagnosis
