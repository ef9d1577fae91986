#include "uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "blocks.hpp"
#include "statistics.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::Parameter;

/// Of the effects' parameters: as the noise model has it, and by the scatter of blocks (sandwich).
struct Covariance {
  Eigen::MatrixXd model, robust;
  Eigen::VectorXd scale;  ///< 0 where the data say nothing
};

/// X: whitened columns of all unknowns; those of zeros are held as they are.
Covariance covariance_of(const Problem& problem, const Fit& fit, const Eigen::MatrixXd& X) {
  const Eigen::VectorXd e = problem.noise().apply_vector(problem, fit.residual);
  Eigen::MatrixXd H = X.transpose() * X;
  const Eigen::Index offset_count = problem.offset_sigma().size(), m = H.rows() - offset_count;
  H.diagonal().tail(offset_count) += problem.offset_sigma().cwiseAbs2().cwiseInverse();
  Eigen::VectorXd scale(H.rows());
  for (Eigen::Index k = 0; k < H.rows(); ++k) scale[k] = H(k, k) > 0 ? 1.0 / std::sqrt(H(k, k)) : 0.0;
  Eigen::MatrixXd h = scale.asDiagonal() * H * scale.asDiagonal();
  h.diagonal().array() += 1e-12;
  const Eigen::MatrixXd inverse =
      scale.asDiagonal() * h.ldlt().solve(Eigen::MatrixXd::Identity(h.rows(), h.rows())) * scale.asDiagonal();
  int count = 0;
  const std::vector<int> block = blocks_of(problem, count);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(H.rows(), count);
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c)
    for (int i = 0; i < n; ++i)
      scores.col(block[static_cast<std::size_t>(i)]) += e[c * n + i] * X.row(c * n + i).transpose();
  // what tolerances hold against the data is no scatter
  scores.colwise() -= scores.rowwise().mean().eval();
  const double small_sample = count > 1 ? static_cast<double>(count) / (count - 1) : 1.0;
  const Eigen::MatrixXd robust = small_sample * inverse * (scores * scores.transpose()) * inverse;
  return {inverse.topLeftCorner(m, m), robust.topLeftCorner(m, m), scale.head(m)};
}

Eigen::VectorXd standard_errors(const Covariance& c) {
  Eigen::VectorXd se(c.model.rows());
  for (Eigen::Index k = 0; k < se.size(); ++k) {
    se[k] = std::sqrt(std::max({c.model(k, k), c.robust(k, k), 0.0}));
    if (c.scale[k] == 0.0) se[k] = 1e9;  // the data say nothing about it
  }
  return se;
}

std::vector<double> distances_from_nothing(const Covariance& c, const Fit& fit) {
  std::vector<double> out;
  Eigen::Index at = 0;
  for (const ActiveEffect& e : fit.effects) {
    std::vector<Eigen::Index> own;
    std::vector<double> off;
    for (std::size_t k = 0; k < e.theta.size(); ++k, ++at) {
      const Parameter& p = e.effect->info().parameters[k];
      if (is_shape(p) || c.scale[at] == 0.0) continue;
      own.push_back(at);
      off.push_back(e.theta[k] - p.neutral);
    }
    const auto m = static_cast<Eigen::Index>(own.size());
    const Eigen::Map<const Eigen::VectorXd> d(off.data(), m);
    double least = m > 0 ? 1e300 : 0.0;
    for (const Eigen::MatrixXd* whole : {&c.model, &c.robust}) {
      Eigen::MatrixXd C(m, m);
      Eigen::VectorXd size(m);
      for (Eigen::Index i = 0; i < m; ++i) size[i] = std::sqrt(std::max(c.model(own[i], own[i]), 1e-300));
      for (Eigen::Index i = 0; i < m; ++i)
        for (Eigen::Index k = 0; k < m; ++k) C(i, k) = (*whole)(own[i], own[k]) / (size[i] * size[k]);
      C.diagonal().array() += 1e-9;
      const Eigen::VectorXd scaled = d.cwiseQuotient(size);
      if (m > 0) least = std::min(least, scaled.dot(C.ldlt().solve(scaled)));
    }
    out.push_back(m > 0 ? std::sqrt(chi_squared_quantile(
                              std::clamp(chi_squared_tail(least, static_cast<double>(m)), 1e-300, 1.0), 1))
                        : 0.0);
  }
  return out;
}

}  // namespace

Uncertainty uncertainty_of(const Problem& problem, const Fit& fit) {
  Eigen::MatrixXd X = problem.whitened(fit.effects, jacobian_of(problem, fit));
  const Covariance whole = covariance_of(problem, fit, X);
  // how strong a law is may be all but unknown while its bend is, on a flight that is nowhere but in one
  // place; that it is not nothing may be certain all the same. Off instruments, where feedback colours the
  // state, a bend that is not known stays reason for doubt.
  Eigen::Index at = 0;
  bool bent = false;
  for (const ActiveEffect& e : fit.effects)
    for (const Parameter& p : e.effect->info().parameters) {
      if (is_shape(p) && problem.instrumented()) X.col(at).setZero(), bent = true;
      ++at;
    }
  const Covariance held = bent ? covariance_of(problem, fit, X) : whole;
  return {standard_errors(whole), distances_from_nothing(held, fit)};
}

}  // namespace omniflight::diagnosis
