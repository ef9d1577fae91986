#include "held_out.hpp"

#include <array>
#include <filesystem>

#include "../improvement.hpp"
#include "../statistics.hpp"
#include "../text.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr std::array<const char*, 6> kWrench{"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
constexpr std::array<const char*, 3> kSpecificForce{"ax", "ay", "az"};

/// Sum of what laws whose loads begin at rest do.
Eigen::VectorXd wrench_of_laws(const RegressionProblem& problem, const std::vector<EffectTerm>& laws,
                               States states) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(problem.rows()), value;
  for (const EffectTerm& law : laws) {
    problem.wrench_of(law, value, nullptr, nullptr, states);
    sum += value;
  }
  return sum;
}

/// What one standard deviation of each initial state of these laws' loads does, rows x states.
Eigen::MatrixXd start_columns(const RegressionProblem& problem, const std::vector<EffectTerm>& laws) {
  std::vector<Eigen::VectorXd> columns;
  Eigen::VectorXd value;
  for (const EffectTerm& law : laws) {
    const std::vector<double> spread = law.effect->start_spread(law.theta.data());
    if (spread.empty()) continue;
    Eigen::MatrixXd by_start;
    problem.wrench_of(law, value, nullptr, &by_start);
    for (Eigen::Index k = 0; k < by_start.cols(); ++k)
      columns.emplace_back(spread[static_cast<std::size_t>(k) % spread.size()] * by_start.col(k));
  }
  Eigen::MatrixXd out(problem.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = columns[k];
  return out;
}

/// Residual at measured states beside these laws, the likeliest calibration and initial states.
Eigen::VectorXd what_is_left(RegressionProblem& problem, const SlowColumns& slow,
                             const std::vector<EffectTerm>& laws) {
  problem.expect(laws);
  const Eigen::VectorXd expected = wrench_of_laws(problem, laws, States::predicted);
  const auto noise = estimate_noise(problem, slow, expected, 1);
  const Calibration& calibration = problem.calibration();
  const Eigen::MatrixXd start = start_columns(problem, laws);
  Eigen::MatrixXd own(problem.rows(), calibration.columns.cols() + start.cols());
  own << calibration.columns, start;
  const Eigen::MatrixXd X = noise->apply(own);
  Eigen::MatrixXd precision = X.transpose() * X;
  precision.diagonal().array() += 1;
  const Eigen::VectorXd likeliest =
      precision.llt().solve(X.transpose() * noise->apply(problem.residual() - expected));
  return problem.residual() - wrench_of_laws(problem, laws, States::measured) -
         calibration.measured * likeliest.head(calibration.columns.cols()) -
         start * likeliest.tail(start.cols());
}

/// Mass and inertia times measured acceleration: what all forces and torques on the body come to.
Eigen::VectorXd measured_wrench(const RegressionProblem& problem) {
  const int n = problem.samples();
  Eigen::VectorXd out(problem.rows());
  for (int i = 0; i < n; ++i) {
    const physics::Situation& s = problem.measured(i);
    const Vec3 force = s.mass * (s.a_WB_B - s.g_B), &w = s.body.w_WB_B;
    const Vec3 torque = s.inertia * s.dw_WB_B + w.cross(s.inertia * w);
    for (int c = 0; c < 3; ++c) out[c * n + i] = force[c], out[(c + 3) * n + i] = torque[c];
  }
  return out;
}

/// Channels that are not judged (torques where thrust is only modelled) are left out.
std::vector<ChannelFit> before_and_after(const Flight& flight, const std::vector<EffectTerm>& laws,
                                         const Inference& inference, const vehicle::Vehicle& vehicle,
                                         const Options& o, const std::string& name) {
  const Flight* one[] = {&flight};
  RegressionProblem problem(one, vehicle, o, inference.horizon.horizon_s());
  if (problem.samples() == 0) return {};
  const SlowColumns slow = slow_columns(problem);
  const Eigen::VectorXd before = what_is_left(problem, slow, {}), after = what_is_left(problem, slow, laws),
                        measured = measured_wrench(problem);
  const int n = problem.samples();
  const auto explained = [&](const Eigen::VectorXd& left, int c) {
    const auto m = measured.segment(c * n, n).array();
    const auto l = left.segment(c * n, n).array();
    const double all = (m - m.mean()).square().sum();
    return all > 0 ? 1 - (l - l.mean()).square().sum() / all : std::nan("");
  };
  std::vector<ChannelFit> out;
  for (int c = 0; c < (problem.forces_only() ? 3 : 6); ++c)
    out.push_back({name, kWrench[static_cast<std::size_t>(c)], c < 3 ? "N" : "Nm",
                   rms(before.segment(c * n, n)), rms(after.segment(c * n, n)), explained(before, c),
                   explained(after, c)});
  for (int c = 0; c < 3; ++c) {
    ChannelFit force = out[static_cast<std::size_t>(c)];
    force.channel = kSpecificForce[static_cast<std::size_t>(c)];
    force.unit = "m/s2";
    force.rms_before /= vehicle.mass;
    force.rms_after /= vehicle.mass;
    out.push_back(std::move(force));
  }
  return out;
}

/// Their loads begin at rest.
std::vector<EffectTerm> laws_of(const std::vector<Hypothesis>& hypotheses,
                                const std::vector<SetMember>& members) {
  std::vector<EffectTerm> out;
  for (const SetMember& m : members)
    out.push_back({hypotheses[static_cast<std::size_t>(m.hypothesis)].effect, m.theta, {}});
  return out;
}

/// Members of the best set that are laws.
std::vector<SetMember> chosen(const Inference& in, std::span<const std::size_t> members) {
  std::vector<SetMember> out;
  for (const std::size_t k : members) {
    const SetMember& m = in.posterior.best.members[k];
    if (in.hypotheses[static_cast<std::size_t>(m.hypothesis)].effect != nullptr) out.push_back(m);
  }
  return out;
}

/// These laws fitted to another flight, from the values they have.
std::vector<EffectTerm> refitted(const Inference& in, std::vector<SetMember> members, const Flight& flight,
                                 const vehicle::Vehicle& vehicle, const Options& o) {
  const Flight* one[] = {&flight};
  RegressionProblem problem(one, vehicle, o, in.horizon.horizon_s());
  problem.expect(laws_of(in.hypotheses, members));
  const auto noise =
      estimate_noise(problem, slow_columns(problem),
                     wrench_of_laws(problem, laws_of(in.hypotheses, members), States::predicted), 1);
  std::vector<Hypothesis> few;
  for (SetMember& m : members) {
    few.push_back(without_grid(in.hypotheses[static_cast<std::size_t>(m.hypothesis)], problem, *noise));
    m.hypothesis = static_cast<int>(few.size()) - 1;
    m.start.resize(0);
  }
  const Evidence evidence(problem, *noise, few, o.law_error,
                          Eigen::VectorXd::Ones(problem.calibration().settled.size()));
  return laws_of(few, evidence.fit(std::move(members)).members);
}

}  // namespace

std::vector<ChannelFit> on_unseen_flights(const Inference& inference, std::span<const std::size_t> members,
                                          const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle,
                                          const Options& o) {
  const std::vector<EffectTerm> laws = laws_of(inference.hypotheses, chosen(inference, members));
  std::vector<ChannelFit> out;
  for (const Flight& f : unseen) {
    if (o.stopped()) break;
    for (ChannelFit& c : before_and_after(f, laws, inference, vehicle, o, f.file))
      out.push_back(std::move(c));
  }
  return out;
}

std::vector<ChannelFit> on_thirds(const Inference& inference, std::span<const std::size_t> members,
                                  const Flight& flight, const vehicle::Vehicle& vehicle, const Options& o) {
  constexpr int kFolds = 3;
  constexpr double kLeast_s = 3;  ///< of a part: less has no noise spectrum to speak of
  const std::vector<SetMember> laws = chosen(inference, members);
  const std::string file = std::filesystem::path(flight.file).filename();
  const double from = flight.t.front(), span = flight.t.back() - from;
  std::vector<ChannelFit> out;
  for (int k = 0; k < kFolds && !laws.empty(); ++k) {
    if (o.stopped()) break;
    const double a = from + span * k / kFolds, b = from + span * (k + 1) / kFolds;
    const Flight rest = part_of(flight, a, b, false), block = part_of(flight, a, b, true);
    if (rest.usable() < kLeast_s * rest.rate_hz || block.usable() < kLeast_s * block.rate_hz) continue;
    for (ChannelFit& c :
         before_and_after(block, refitted(inference, laws, rest, vehicle, o), inference, vehicle, o,
                          format("%s [%.1f s to %.1f s, not fitted]", file.c_str(), a, b)))
      out.push_back(std::move(c));
  }
  return out;
}

}  // namespace omniflight::diagnosis
