#include "detectability.hpp"

#include <algorithm>
#include <cmath>

#include "../discrepancy/state_variables.hpp"
#include "../evidence/noise_estimate.hpp"
#include "../numerics/statistics.hpp"
#include "../regression/predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

/// Cosine of the angle between a direction and the span of the columns of Z.
double cosine_of(Eigen::MatrixXd Z, const Eigen::VectorXd& direction) {
  const double size = direction.squaredNorm();
  if (!(size > 0)) return 0;
  for (Eigen::Index k = 0; k < Z.cols(); ++k)
    if (const double norm = Z.col(k).norm(); norm > 0) Z.col(k) /= norm;
  Eigen::MatrixXd H = Z.transpose() * Z;
  H.diagonal().array() += 1e-9;
  const Eigen::VectorXd g = Z.transpose() * direction;
  return std::sqrt(std::clamp(g.dot(H.ldlt().solve(g)) / size, 0.0, 1.0));
}

/// Whitened contribution of a candidate at typical parameters, and its Jacobian.
struct Shown {
  Eigen::MatrixXd columns;
  Eigen::VectorXd value;
};

Shown shown(const RegressionProblem& problem, const NoiseModel& noise, const physics::Effect& effect) {
  EffectTerm term{&effect, {}, {}};
  for (const physics::Parameter& p : effect.info().parameters) term.theta.push_back(p.typical);
  Eigen::VectorXd value;
  Eigen::MatrixXd by_theta;
  problem.wrench_of(term, value, &by_theta, nullptr, States::measured);
  return {noise.apply(by_theta), noise.apply(value)};
}

/// Adds groups of collinear candidates, among those with a whitened norm of at least 1.
void group(const std::vector<const physics::Effect*>& candidates, const std::vector<Shown>& all,
           Intake& intake) {
  constexpr double kAlike = 0.98;  // cosine, 11 deg; chosen
  std::vector<int> group(all.size(), -1);
  const auto alike = [&](const Shown& a, const Shown& b) {
    return cosine_of(b.columns, a.value) > kAlike && cosine_of(a.columns, b.value) > kAlike;
  };
  int groups = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].value.norm() < 1) continue;
    for (std::size_t j = 0; j < i && group[i] < 0; ++j)
      if (group[j] >= 0 && alike(all[i], all[j])) group[i] = group[j];
    if (group[i] < 0) group[i] = groups++;
  }
  for (int g = 0; g < groups; ++g) {
    std::vector<std::string> ids;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (group[i] == g) ids.push_back(candidates[i]->info().id);
    if (ids.size() > 1) intake.alias_groups.push_back(ids);
  }
}

}  // namespace

void describe_candidates(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                         const std::vector<const physics::Effect*>& candidates, const Options& o,
                         Intake& intake) {
  const RegressionProblem problem(flights, vehicle, o, Horizon{least_horizon(flights)});
  for (const StateVariable& v : state_variables(problem)) {
    if (v.x.size() == 0) continue;
    intake.excitation.push_back(
        {v.name, v.unit, v.x.minCoeff(), v.x.maxCoeff(), rms((v.x.array() - v.x.mean()).matrix())});
  }
  const auto noise = estimate_noise(problem, slow_columns(problem), Eigen::VectorXd::Zero(problem.rows()),
                                    problem.temperature());
  // project out what calibration within its tolerances can imitate
  const Eigen::MatrixXd Z = noise->apply(problem.calibration().measured);
  Eigen::MatrixXd H = Z.transpose() * Z;
  H.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> calibration(H);
  std::vector<Shown> all;
  for (const physics::Effect* candidate : candidates) {
    if (o.stopped()) return;
    all.push_back(shown(problem, *noise, *candidate));
    const Eigen::VectorXd g = Z.transpose() * all.back().value;
    const double seen = all.back().value.squaredNorm() - g.dot(calibration.solve(g));
    intake.detectability.push_back({candidate->info().id, std::sqrt(std::max(0.0, seen))});
  }
  group(candidates, all, intake);
}

}  // namespace omniflight::diagnosis
