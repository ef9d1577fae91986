#include "intake.hpp"

#include <algorithm>
#include <cmath>

#include "imitation.hpp"
#include "missing.hpp"
#include "offered.hpp"
#include "sensor_health.hpp"
#include "state_variables.hpp"
#include "statistics.hpp"

namespace omniflight::diagnosis {

Intake describe(const recording::Recording& r, const Flight& f) {
  Intake out;
  out.recording = r.file;
  out.sensors = sensor_facts(r);
  out.missing = missing_signals(r);
  for (const auto& [name, s] : r.signals) {
    if (s.empty() || name.rfind("truth_", 0) == 0) continue;
    SignalInfo info{name, s.unit, static_cast<int>(s.size()), 0, 0};
    if (const double period = s.median_period_s(); period > 0) info.rate_hz = 1 / period;
    for (std::size_t i = 1; i < s.t_s.size(); ++i)
      info.longest_gap_s = std::max(info.longest_gap_s, s.t_s[i] - s.t_s[i - 1]);
    out.signals.push_back(info);
  }
  out.alignment = f.alignment;
  out.notes = f.notes;
  return out;
}

void describe_candidates(const Problem& problem, const std::vector<const physics::Effect*>& candidates,
                         Intake& intake) {
  for (const StateVariable& v : state_variables(problem)) {
    if (v.x.size() == 0) continue;
    intake.excitation.push_back(
        {v.name, v.unit, v.x.minCoeff(), v.x.maxCoeff(), rms((v.x.array() - v.x.mean()).matrix())});
  }
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.offset_sigma().size());
  const Eigen::VectorXd& nothing = problem.residual();
  // what offsets within their tolerances can imitate does not count
  const Eigen::MatrixXd Z = problem.noise().apply(problem, problem.offsets());
  Eigen::MatrixXd H = Z.transpose() * Z;
  H.diagonal() += problem.offset_sigma().cwiseAbs2().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> offsets(H);
  const auto m = candidates.size();
  std::vector<Eigen::MatrixXd> columns(m);
  std::vector<Eigen::VectorXd> values(m);
  for (std::size_t k = 0; k < m; ++k) {
    physics::ActiveEffect e{candidates[k], {}};
    for (const physics::Parameter& p : candidates[k]->info().parameters) e.theta.push_back(p.typical);
    Eigen::VectorXd rest;
    Eigen::MatrixXd jacobian;
    problem.predict({e}, none, rest, &jacobian);
    values[k] = problem.noise().apply_vector(problem, nothing - rest);
    columns[k] = problem.noise().apply(problem, jacobian.leftCols(candidates[k]->parameter_count()));
    const Eigen::VectorXd g = Z.transpose() * values[k];
    const double seen = values[k].squaredNorm() - g.dot(offsets.solve(g));
    intake.detectability.push_back({candidates[k]->info().id, std::sqrt(std::max(0.0, seen))});
  }
  std::vector<int> group(m, -1);
  const auto alike = [&](std::size_t i, std::size_t j) {
    return cosine_of(columns[j], values[i]) > 0.98 && cosine_of(columns[i], values[j]) > 0.98;
  };
  int groups = 0;
  for (std::size_t i = 0; i < m; ++i) {
    if (intake.detectability[i].sigma < 1 && values[i].norm() < 1) continue;  // does not show at all
    for (std::size_t j = 0; j < i; ++j)
      if (group[j] >= 0 && alike(i, j)) {
        group[i] = group[j];
        break;
      }
    if (group[i] < 0) group[i] = groups++;
  }
  for (int g = 0; g < groups; ++g) {
    std::vector<std::string> ids;
    for (std::size_t i = 0; i < m; ++i)
      if (group[i] == g) ids.push_back(candidates[i]->info().id);
    if (ids.size() > 1) intake.alias_groups.push_back(ids);
  }
}

}  // namespace omniflight::diagnosis
