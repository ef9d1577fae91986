#include "profile.hpp"

#include <algorithm>

#include "../evidence/tolerances.hpp"
#include "../numerics/parallel.hpp"
#include "inference.hpp"

namespace omniflight::diagnosis {
namespace {

/// Noise and set in turn: the second knows the calibration, the third its tolerances.
constexpr int kPasses = 3;

/// A set that has not been fitted yet.
Profile begin(std::vector<SetMember> members, const Eigen::VectorXd& tolerances) {
  Profile out;
  out.tolerances = tolerances;
  out.fit.members = std::move(members);
  return out;
}

}  // namespace

Profile Profiler::of(std::vector<SetMember> members, const Eigen::VectorXd& tolerances) const {
  Profile out = begin(std::move(members), tolerances);
  for (int pass = 0; pass < kPasses && (pass == 0 || !o_.stopped()); ++pass) turn(out);
  return out;
}

Profile Profiler::best_of(const std::vector<std::vector<SetMember>>& sets,
                          const Eigen::VectorXd& tolerances) const {
  std::vector<Profile> all(sets.size());
  for (std::size_t k = 0; k < sets.size(); ++k) all[k] = begin(sets[k], tolerances);
  for (int pass = 0; pass < kPasses && (pass == 0 || !o_.stopped()); ++pass) {
    parallel_for(
        all.size(), o_.threads, [&](std::size_t k) { turn(all[k]); }, o_.stop);
    std::stable_sort(all.begin(), all.end(),
                     [](const Profile& x, const Profile& y) { return x.joint > y.joint; });
    all.resize(std::min(all.size(), kTried));
  }
  return std::move(all.front());
}

/// At the accelerations that the rotors give together with what the set did when it was fitted last, or does
/// where it begins. What has mass weighs by them: at those of another set, which leaves some newtons, a load
/// would seem to be lighter or heavier than it is, and the right set would fit worse than a wrong one.
void Profiler::turn(Profile& p) const {
  if (p.expected.size() == 0) p.expected = wrench_of_set(problem_, hypotheses_, p.fit, States::predicted);
  if (problem_.expects(p.expected)) return fit(problem_, p);
  RegressionProblem own(problem_);
  own.expect(p.expected);
  for (SetMember& m : p.fit.members) m.first_stage.reset();
  fit(own, p);
}

/// Noise beside the set and the calibration that were fitted last, then set and tolerances in it.
void Profiler::fit(const RegressionProblem& problem, Profile& p) const {
  std::vector<Hypothesis> few;
  std::vector<int> index;
  double log_prior = 0;
  for (SetMember& m : p.fit.members) {
    index.push_back(m.hypothesis);
    few.push_back(without_grid(hypotheses_[static_cast<std::size_t>(m.hypothesis)]));
    log_prior += few.back().log_odds;
    m.hypothesis = static_cast<int>(few.size()) - 1;
  }
  const auto known = [&] {
    Eigen::VectorXd out = wrench_of_set(problem, few, p.fit, States::predicted);
    if (p.fit.calibration.size() > 0) out += problem.calibration().columns * p.fit.calibration;
    return out;
  };
  const bool fitted = p.fit.calibration.size() > 0;
  p.noise = estimate_noise(problem_, slow_, known(), problem_.temperature(), ToldShape::corrected,
                           fitted ? LoneSamples::sought : LoneSamples::none);  // it outlives `problem`
  for (Hypothesis& h : few) h = without_grid(h, problem, *p.noise);
  const Evidence evidence(problem, fitted_, *p.noise, few, o_.error_of_laws(), p.tolerances);
  p.fit = evidence.fit(std::move(p.fit.members));
  Eigen::VectorXd likeliest = p.tolerances;
  if (o_.assumes(Assumption::tolerance_factors))
    likeliest = likeliest_tolerances(problem.calibration(), p.fit, p.tolerances);
  if (likeliest != p.tolerances) {
    p.tolerances = std::move(likeliest);
    p.fit = evidence.with(p.tolerances).fit(std::move(p.fit.members));
  }
  p.expected = known();
  p.joint = p.fit.log_evidence + log_prior - p.noise->log_scale() + p.noise->log_prior() +
            log_prior_of_tolerances(problem.calibration(), p.tolerances);
  for (std::size_t k = 0; k < index.size(); ++k) p.fit.members[k].hypothesis = index[k];
}

}  // namespace omniflight::diagnosis
