#include "held_out.hpp"

#include "../evidence/inner_products.hpp"
#include "improvement.hpp"

namespace omniflight::diagnosis {
namespace {

/// Wrench per standard deviation of each initial state of the laws, rows x states.
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

/// Residual after the laws, the calibration and the initial states, the latter two at their posterior mean
/// given this recording. Evaluated at measured states.
Eigen::VectorXd what_is_left(RegressionProblem& problem, const SlowColumns& slow,
                             const std::vector<EffectTerm>& laws) {
  problem.expect(laws);
  const Eigen::VectorXd expected = problem.wrench_of(laws);
  const auto noise = estimate_noise(problem, slow, expected, 1, ToldShape::corrected, LoneSamples::sought);
  const Calibration& calibration = problem.calibration();
  const Eigen::MatrixXd start = start_columns(problem, laws);
  Eigen::MatrixXd own(problem.rows(), calibration.columns.cols() + start.cols());
  own << calibration.columns, start;
  const Eigen::MatrixXd X = noise->apply(own);
  Eigen::MatrixXd precision = inner_products(X);
  precision.diagonal().array() += 1;
  const Eigen::VectorXd likeliest =
      precision.llt().solve(X.transpose() * noise->apply(noise->residual() - expected));
  return problem.residual() - problem.wrench_of(laws, States::measured) -
         calibration.measured * likeliest.head(calibration.columns.cols()) -
         start * likeliest.tail(start.cols());
}

/// Fits of all judged channels (no torques where thrust is modelled from duty cycles).
std::vector<ChannelFit> before_and_after(const Flight& flight, const std::vector<EffectTerm>& laws,
                                         const Inference& inference, const vehicle::Vehicle& vehicle,
                                         const Options& o, const std::string& name) {
  const Flight* one[] = {&flight};
  RegressionProblem problem(one, vehicle, o, inference.horizon.horizon());
  if (problem.samples() == 0) return {};
  const SlowColumns slow = slow_columns(problem);
  const Eigen::VectorXd before = what_is_left(problem, slow, {}), after = what_is_left(problem, slow, laws);
  const int n = problem.samples();
  Eigen::VectorXd measured(problem.rows());
  for (int i = 0; i < n; ++i) {
    const Vec6 wrench = measured_wrench(problem.measured(i));
    for (int c = 0; c < 6; ++c) measured[c * n + i] = wrench[c];
  }
  return channel_fits(name, measured, before, after, problem.forces_only() ? 3 : 6, vehicle.mass);
}

/// The effects of the members at their parameters, initial states at rest.
std::vector<EffectTerm> laws_of(const std::vector<Hypothesis>& hypotheses,
                                const std::vector<SetMember>& members) {
  std::vector<EffectTerm> out;
  for (const SetMember& m : members)
    out.push_back({hypotheses[static_cast<std::size_t>(m.hypothesis)].effect, m.theta, {}});
  return out;
}

/// Members that are effects of the library.
std::vector<SetMember> laws_among(const Inference& in, const SetFit& set) {
  std::vector<SetMember> out;
  for (const SetMember& m : set.members)
    if (in.hypotheses[static_cast<std::size_t>(m.hypothesis)].effect != nullptr) out.push_back(m);
  return out;
}

/// The members fitted to another flight, starting from their values.
std::vector<EffectTerm> refitted(const Inference& in, std::vector<SetMember> members, const Flight& flight,
                                 const vehicle::Vehicle& vehicle, const Options& o) {
  const Flight* one[] = {&flight};
  RegressionProblem problem(one, vehicle, o, in.horizon.horizon());
  const std::vector<EffectTerm> laws = laws_of(in.hypotheses, members);
  problem.expect(laws);
  const auto noise = estimate_noise(problem, slow_columns(problem), problem.wrench_of(laws), 1);
  std::vector<Hypothesis> few;
  for (SetMember& m : members) {
    few.push_back(without_grid(in.hypotheses[static_cast<std::size_t>(m.hypothesis)], problem, *noise));
    m.hypothesis = static_cast<int>(few.size()) - 1;
    m.start.resize(0);
  }
  const Evidence evidence(problem, *noise, few, o.error_of_laws(),
                          Eigen::VectorXd::Ones(problem.calibration().settled.size()));
  return laws_of(few, evidence.fit(std::move(members)).members);
}

}  // namespace

std::vector<ChannelFit> on_unseen_flights(const Inference& inference, const SetFit& set,
                                          const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle,
                                          const Options& o) {
  const std::vector<EffectTerm> laws = laws_of(inference.hypotheses, laws_among(inference, set));
  std::vector<ChannelFit> out;
  for (const Flight& f : unseen) {
    if (o.stopped()) break;
    for (ChannelFit& c : before_and_after(f, laws, inference, vehicle, o, f.file))
      out.push_back(std::move(c));
  }
  return out;
}

std::vector<ChannelFit> on_thirds(const Inference& inference, const SetFit& set, const Flight& flight,
                                  const vehicle::Vehicle& vehicle, const Options& o) {
  constexpr double kLeast_s = 3;  ///< s, of a part; chosen: a shorter one determines no noise spectrum
  const std::vector<SetMember> laws = laws_among(inference, set);
  std::vector<ChannelFit> out;
  for (int k = 0; k < kThirds && !laws.empty() && !o.stopped(); ++k) {
    const auto third = third_of(flight, k, kLeast_s, kLeast_s);
    if (!third) continue;
    for (ChannelFit& c : before_and_after(third->block, refitted(inference, laws, third->rest, vehicle, o),
                                          inference, vehicle, o, third->name))
      out.push_back(std::move(c));
  }
  return out;
}

}  // namespace omniflight::diagnosis
