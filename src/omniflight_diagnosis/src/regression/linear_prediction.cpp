#include "linear_prediction.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace omniflight::diagnosis {
namespace {

/// Ridge penalties tried, relative to the variance of a standardised regressor: from numerical regularisation
/// to strong shrinkage. Chosen by decades.
constexpr std::array<double, 6> kRidges{1e-6, 1e-4, 1e-3, 1e-2, 1e-1, 1};
constexpr Eigen::Index kFolds = 5;  ///< of cross-fitting; chosen

Eigen::MatrixXd standardised(const Eigen::MatrixXd& known) {
  Eigen::MatrixXd X = known.rowwise() - known.colwise().mean();
  for (Eigen::Index k = 0; k < X.cols(); ++k) {
    const double deviation = std::sqrt(X.col(k).squaredNorm() / static_cast<double>(X.rows()));
    X.col(k) *= deviation > 0 ? 1 / deviation : 0.0;
  }
  return X;
}

}  // namespace

LinearPrediction::LinearPrediction(const Eigen::MatrixXd& known, int block, int apart)
    : X_(standardised(known)),
      block_(static_cast<int>(
          std::max<Eigen::Index>(apart / 2 + 1, std::min<Eigen::Index>(block, known.rows() / kFolds)))),
      apart_(apart) {
  const Eigen::MatrixXd H = X_.transpose() * X_;
  for (Eigen::Index fold = 0; fold < kFolds; ++fold) {
    Eigen::MatrixXd others = H;
    each_block(fold, [&](Eigen::Index, Eigen::Index, Eigen::Index from, Eigen::Index left_out) {
      const auto x = X_.middleRows(from, left_out);
      others.noalias() -= x.transpose() * x;
    });
    factors_.emplace_back();
    for (const double ridge : kRidges) {
      Eigen::MatrixXd ridged = others;
      ridged.diagonal().array() += ridge * static_cast<double>(X_.rows());
      factors_.back().emplace_back(ridged);
    }
  }
}

/// Calls visit(begin, end, first row left out, number of rows left out) for each block of a fold.
template <class Visit>
void LinearPrediction::each_block(Eigen::Index fold, const Visit& visit) const {
  const Eigen::Index n = X_.rows();
  for (Eigen::Index begin = fold * block_; begin < n; begin += kFolds * block_) {
    const Eigen::Index end = std::min<Eigen::Index>(n, begin + block_);
    const Eigen::Index from = std::max<Eigen::Index>(0, begin - apart_);
    visit(begin, end, from, std::min<Eigen::Index>(n, end + apart_) - from);
  }
}

Eigen::MatrixXd LinearPrediction::of(const Eigen::MatrixXd& targets) const {
  const Eigen::Index n = X_.rows();
  const Eigen::RowVectorXd mean = targets.colwise().mean();
  const Eigen::MatrixXd Y = targets.rowwise() - mean, moments = X_.transpose() * Y;
  std::array<Eigen::MatrixXd, kRidges.size()> predicted;
  predicted.fill(Eigen::MatrixXd(n, Y.cols()));
  for (Eigen::Index fold = 0; fold < kFolds; ++fold) {
    Eigen::MatrixXd rest = moments;
    each_block(fold, [&](Eigen::Index, Eigen::Index, Eigen::Index from, Eigen::Index left_out) {
      rest.noalias() -= X_.middleRows(from, left_out).transpose() * Y.middleRows(from, left_out);
    });
    for (std::size_t k = 0; k < kRidges.size(); ++k) {
      const Eigen::MatrixXd coefficients = factors_[static_cast<std::size_t>(fold)][k].solve(rest);
      each_block(fold, [&](Eigen::Index begin, Eigen::Index end, Eigen::Index, Eigen::Index) {
        predicted[k].middleRows(begin, end - begin) = X_.middleRows(begin, end - begin) * coefficients;
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
    // Rescale to unit slope: shrinkage of the instrument would inflate the coefficient by the same factor.
    const double slope = power > 0 ? std::max(0.0, best->col(c).dot(Y.col(c)) / power) : 0.0;
    out.col(c) = slope * best->col(c).array() + mean[c];
  }
  return out;
}

Eigen::MatrixXd predict_linearly(const Eigen::MatrixXd& known, const Eigen::MatrixXd& targets, int block,
                                 int apart) {
  return LinearPrediction(known, block, apart).of(targets);
}

}  // namespace omniflight::diagnosis
