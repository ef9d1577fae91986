#include "causality.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

constexpr double kSoonest = 0.05, kLatest = 0.125;  // s, from a disturbance to the thrust against it
constexpr double kNats = 2.0, kShare = 0.2;  // by which a gain must be larger, and as share of the other

/// What stands `ahead` samples later, brought to the present; at its ends a run is held.
Eigen::VectorXd brought_forward(const Problem& problem, const Eigen::VectorXd& value, int ahead) {
  Eigen::VectorXd out(value.size());
  for (int channel = 0; channel < 6; ++channel)
    for (const Run& run : problem.runs())
      for (int i = run.begin; i < run.end; ++i)
        out[channel * problem.samples() + i] =
            value[channel * problem.samples() + std::clamp(i + ahead, run.begin, run.end - 1)];
  return out;
}

}  // namespace

bool answers_instead_of_causing(const Problem& problem, const Fit& fit, std::size_t index,
                                const Options& options) {
  if (problem.instrumented() || !fit.effects[index].effect->linear_in_thrust()) return false;
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < index; ++k) first += fit.effects[k].effect->parameter_count();
  const Eigen::Index width = fit.effects[index].effect->parameter_count();
  const Eigen::MatrixXd X = problem.whitened(fit.effects, jacobian_of(problem, fit));
  Eigen::MatrixXd others(X.rows(), X.cols() - width);
  others << X.leftCols(first), X.rightCols(X.cols() - first - width);
  const auto solver = others.colPivHouseholderQr();
  const auto beyond_others = [&](const Eigen::VectorXd& raw) -> Eigen::VectorXd {
    const Eigen::VectorXd v = problem.noise().apply_vector(problem, raw);
    return v - others * solver.solve(v);
  };
  const Eigen::VectorXd value = contribution_of(problem, fit, index);
  const Eigen::VectorXd rest = beyond_others(fit.residual + value);
  const auto gain = [&](int ahead) {
    const Eigen::VectorXd own = beyond_others(brought_forward(problem, value, ahead));
    return own.squaredNorm() > 0 ? 0.5 * std::pow(own.dot(rest), 2) / own.squaredNorm() : 0.0;
  };
  const double here = gain(0);
  const auto in_samples = [&](double s) { return static_cast<int>(std::lround(s * options.grid_hz)); };
  for (int ahead = std::max(1, in_samples(kSoonest)); ahead <= in_samples(kLatest); ++ahead)
    // behind as well: what an offset can do as well gains by being moved, whichever way
    if (gain(ahead) > kNats + std::max((1 + kShare) * here, gain(-ahead))) return true;
  return false;
}

}  // namespace omniflight::diagnosis
