#include "named_set.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

/// Of the weight (times the lever): what does less is what arithmetic leaves of a vehicle file and a log, and
/// no physics that was left out.
constexpr double kLeastWrench = 1e-4;

/// Whether a member of the best set does anything worth a name.
bool does_something(const Inference& in, const SetMember& member) {
  const RegressionProblem& problem = *in.problem;
  const Hypothesis& h = in.hypotheses[static_cast<std::size_t>(member.hypothesis)];
  Eigen::VectorXd wrench;
  if (h.pattern)
    wrench = h.pattern->raw * member.weights;
  else
    problem.wrench_of({h.effect, member.theta, member.start}, wrench, nullptr, nullptr, States::measured);
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c)
    if (rms(wrench.segment(c * n, n)) > kLeastWrench * problem.scale(c)) return true;
  return false;
}

/// The candidate that is likeliest were laws as right as they are said to be, or set that is not empty where
/// none is one: fitted in the noise of the best set, which may be another one or none at all, since rivals
/// count in their own noise.
SetFit likeliest_of_something(const Inference& in, const Evidence& evidence) {
  const Posterior& p = in.posterior;
  const auto rank = [&](const SetPosterior& s) {
    return std::tuple(!s.hypotheses.empty(), p.is_candidate(s), s.sharp_share);
  };
  const auto likeliest =
      std::max_element(p.sets.begin(), p.sets.end(),
                       [&](const SetPosterior& a, const SetPosterior& b) { return rank(a) < rank(b); });
  std::vector<int> best;
  for (const SetMember& m : p.best.members) best.push_back(m.hypothesis);
  std::sort(best.begin(), best.end());
  return likeliest->hypotheses == best ? p.best : evidence.fit(likeliest->members);
}

/// ln evidence of a set that was visited.
std::optional<double> evidence_of(const Posterior& p, std::vector<int> hypotheses) {
  std::sort(hypotheses.begin(), hypotheses.end());
  for (const SetPosterior& s : p.sets)
    if (s.hypotheses == hypotheses) return s.log_joint - s.log_prior;
  return {};
}

/// Whether the flight speaks for a member of a set beside the others, and not only a prior that was told.
bool is_supported(const Posterior& p, const std::vector<SetMember>& members, std::size_t member) {
  if (members.size() < 2) return true;
  std::vector<int> with, without;
  for (std::size_t k = 0; k < members.size(); ++k) {
    with.push_back(members[k].hypothesis);
    if (k != member) without.push_back(members[k].hypothesis);
  }
  const auto here = evidence_of(p, with), there = evidence_of(p, without);
  return !here || !there || *here > *there;
}

}  // namespace

SetFit named_set(const Inference& in, const Options& o) {
  const Posterior& p = in.posterior;
  if (!p.alarm()) return p.nothing;
  const Evidence evidence(*in.problem, *in.noise, in.hypotheses, o.error_of_laws(), in.tolerances);
  const SetFit best = likeliest_of_something(in, evidence);
  std::vector<std::pair<double, std::size_t>> members;
  for (std::size_t k = 0; k < best.members.size(); ++k) {
    if (!does_something(in, best.members[k]) || !is_supported(p, best.members, k)) continue;
    const int h = best.members[k].hypothesis;
    members.emplace_back(p.inclusion(in.hypotheses[static_cast<std::size_t>(h)].id, in.hypotheses), k);
  }
  std::sort(members.rbegin(), members.rend());
  std::vector<SetMember> named;
  for (const auto& [inclusion, k] : members)
    if (named.empty() || inclusion > kBeside) named.push_back(best.members[k]);
  return named.size() == best.members.size() ? best : evidence.fit(std::move(named));
}

double deviation_over_sets(const Posterior& posterior, const std::vector<Hypothesis>& hypotheses,
                           int hypothesis, std::size_t k, double value) {
  double sum = 0, weight = 0;
  for (const SetPosterior& s : posterior.sets) {
    const double* deviation = s.theta_deviation.data();
    for (const SetMember& m : s.members) {
      if (m.hypothesis == hypothesis) {
        sum += s.probability * (deviation[k] * deviation[k] + std::pow(m.theta[k] - value, 2));
        weight += s.probability;
      }
      if (hypotheses[static_cast<std::size_t>(m.hypothesis)].effect) deviation += m.theta.size();
    }
  }
  return weight > 0 ? std::sqrt(sum / weight) : 0.0;
}

}  // namespace omniflight::diagnosis
