#include "imitation.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

Eigen::MatrixXd last_columns(const Problem& problem, const Whitening& noise, const Fit& fit) {
  Fit last = fit;  // what is heavy weakens the others, but on instruments
  if (!problem.has_inertia(fit.effects)) last.effects = {fit.effects.back()};
  const Eigen::MatrixXd all = jacobian_of(problem, last);
  const Eigen::Index own = fit.effects.back().effect->parameter_count();
  return noise.apply(problem, all.middleCols(all.cols() - problem.offset_sigma().size() - own, own));
}

Eigen::MatrixXd without_free_scale(const Problem& problem, Eigen::MatrixXd columns) {
  if (!problem.forces_only()) return columns;
  const Eigen::VectorXd scale = problem.noise().apply_vector(problem, problem.offsets().col(0)).normalized();
  columns -= scale * (scale.transpose() * columns);
  return columns;
}

Imitator::Imitator(const Eigen::MatrixXd& columns) : Z_(columns) {
  for (Eigen::Index k = 0; k < Z_.cols(); ++k)
    if (const double size = Z_.col(k).norm(); size > 0) Z_.col(k) /= size;
  Eigen::MatrixXd H = Z_.transpose() * Z_;
  H.diagonal().array() += 1e-9;
  solver_.compute(H);
}

double Imitator::cosine(const Eigen::VectorXd& direction) const {
  const double size = direction.squaredNorm();
  if (!(size > 0)) return 0;
  const Eigen::VectorXd g = Z_.transpose() * direction;
  return std::sqrt(std::clamp(g.dot(solver_.solve(g)) / size, 0.0, 1.0));
}

}  // namespace omniflight::diagnosis
