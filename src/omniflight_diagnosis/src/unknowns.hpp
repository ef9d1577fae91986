// What a fit solves for: effect parameters and offsets in one vector, with bounds and priors.
#pragma once

#include <algorithm>

#include "problem.hpp"

namespace omniflight::diagnosis {

/// All unknowns in one vector: effect parameters in order, then offsets, with bounds and priors.
struct Unknowns {
  Eigen::VectorXd x, lower, upper, weight;  ///< weight: 1/sigma^2 of the prior about zero

  Unknowns(const Problem& problem, const std::vector<physics::ActiveEffect>& effects,
           const Eigen::VectorXd* offsets) {
    std::vector<double> v, lo, hi;
    for (const physics::ActiveEffect& e : effects) {
      for (std::size_t k = 0; k < e.theta.size(); ++k) {
        const Range range = problem.range(*e.effect, k);
        lo.push_back(range.lower);
        hi.push_back(range.upper);
        v.push_back(std::clamp(e.theta[k], lo.back(), hi.back()));
      }
    }
    const auto m = static_cast<Eigen::Index>(v.size());
    const Eigen::Index offset_count = problem.offset_sigma().size();
    x = Eigen::VectorXd::Zero(m + offset_count);
    lower = Eigen::VectorXd::Constant(m + offset_count, -1e9);
    upper = -lower;
    weight = Eigen::VectorXd::Zero(m + offset_count);
    for (Eigen::Index k = 0; k < m; ++k) {
      x[k] = v[static_cast<std::size_t>(k)];
      lower[k] = lo[static_cast<std::size_t>(k)];
      upper[k] = hi[static_cast<std::size_t>(k)];
    }
    limit_offsets(problem.offset_sigma());
    if (offsets && offsets->size() == offset_count)
      x.tail(offset_count) = offsets->cwiseMax(lower.tail(offset_count)).cwiseMin(upper.tail(offset_count));
  }

  /// To the limits, from where x is.
  Eigen::VectorXd down() const { return lower - x; }
  Eigen::VectorXd up() const { return upper - x; }

  /// Prior and hard limit of three standard deviations: no amount of data turns a tolerance into an effect.
  void limit_offsets(const Eigen::VectorXd& sigma) {
    weight.tail(sigma.size()) = sigma.cwiseAbs2().cwiseInverse();
    lower.tail(sigma.size()) = -3 * sigma;
    upper.tail(sigma.size()) = 3 * sigma;
  }
};

}  // namespace omniflight::diagnosis
