#include "inference.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

/// Times that the noise is estimated beside the best set so far: laws that are not linear, and whatever else
/// is not a slow function of place, count as noise until they are known.
constexpr int kRounds = 3;

/// ln evidence plus ln prior of a set in the noise that it leaves itself, and that set in it.
struct Profile {
  std::unique_ptr<NoiseModel> noise;
  SetFit fit;
  double joint = -1e300;
};

class Profiler {
 public:
  Profiler(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
           const Eigen::MatrixXd& slow, const Options& o)
      : problem_(problem), hypotheses_(hypotheses), slow_(slow), o_(o) {}

  Profile of(std::vector<SetMember> members) const {
    Profile out;
    std::vector<Hypothesis> few;
    std::vector<int> index;
    double log_prior = 0;
    for (SetMember& m : members) {
      index.push_back(m.hypothesis);
      few.push_back(hypotheses_[static_cast<std::size_t>(m.hypothesis)]);
      log_prior += few.back().log_odds;
      m.hypothesis = static_cast<int>(few.size()) - 1;
    }
    for (int pass = 0; pass < 2; ++pass) {
      SetFit now;
      now.members = members;
      out.noise = estimate_noise(problem_, slow_, wrench_of_set(problem_, few, now), o_.temperature);
      whiten(problem_, *out.noise, 1, few);
      const Evidence evidence(problem_, *out.noise, few, o_.law_error);
      out.fit = evidence.fit(members);
      members = out.fit.members;
    }
    out.joint = out.fit.log_evidence + log_prior - out.noise->log_scale();
    for (std::size_t k = 0; k < index.size(); ++k) out.fit.members[k].hypothesis = index[k];
    return out;
  }

 private:
  const RegressionProblem& problem_;
  const std::vector<Hypothesis>& hypotheses_;
  const Eigen::MatrixXd& slow_;
  const Options& o_;
};

}  // namespace

Eigen::VectorXd wrench_of_set(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
                              const SetFit& set) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(problem.rows()), value;
  for (const SetMember& member : set.members) {
    const Hypothesis& h = hypotheses[static_cast<std::size_t>(member.hypothesis)];
    if (h.pattern) {
      sum += h.pattern->raw * member.weights;
      continue;
    }
    problem.wrench_of({h.effect, member.theta, member.start}, value, nullptr, nullptr);
    sum += value;
  }
  return sum;
}

Inference infer(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                const std::vector<const physics::Effect*>& effects, const Options& o) {
  Inference out;
  out.problem = std::make_unique<RegressionProblem>(flights, vehicle, o);
  const RegressionProblem& problem = *out.problem;
  const Eigen::MatrixXd slow = slow_columns(problem);
  SearchLimits limits;
  limits.threads = o.threads;
  limits.stop = o.stop;
  limits.most_members = 8;
  const auto use = [&](std::unique_ptr<NoiseModel> noise, const std::vector<SetMember>& seed) {
    if (out.hypotheses.empty())
      out.hypotheses = make_hypotheses(problem, *noise, effects, o.threads, o.stop);
    else
      whiten(problem, *noise, o.threads, out.hypotheses);
    out.evidence = std::make_unique<Evidence>(problem, *noise, out.hypotheses, o.law_error);
    out.noise = std::move(noise);
    out.posterior = search(*out.evidence, limits, seed);
  };
  use(estimate_noise(problem, slow, Eigen::VectorXd::Zero(problem.rows()), o.temperature), {});
  const Profiler profiler(problem, out.hypotheses, slow, o);
  const Profile nothing = profiler.of({});
  for (int round = 0; round < kRounds && !out.posterior.best.members.empty() && !o.stopped(); ++round) {
    Profile best = profiler.of(out.posterior.best.members);
    // a member must be worth its place also when the noise may take over what it does
    for (bool dropped = true; dropped && !best.fit.members.empty();) {
      dropped = false;
      Profile better;
      for (std::size_t k = 0; k < best.fit.members.size(); ++k) {
        std::vector<SetMember> rest = best.fit.members;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
        Profile without = profiler.of(std::move(rest));
        if (without.joint > best.joint && without.joint > better.joint) better = std::move(without);
      }
      if (better.joint > best.joint) {
        best = std::move(better);
        dropped = true;
      }
    }
    std::vector<int> before, after;
    for (const SetMember& m : best.fit.members) before.push_back(m.hypothesis);
    const std::vector<SetMember> seed = best.fit.members;
    const double joint = best.joint;
    use(std::move(best.noise), seed);
    // nothing at all, in its own noise
    Posterior& p = out.posterior;
    double sum = 0;
    for (SetPosterior& s : p.sets) {
      if (s.hypotheses.empty() && !seed.empty())
        s.log_joint = std::max(s.log_joint, nothing.joint - joint + p.joint_of_best);
      s.probability = std::exp(std::min(50.0, s.log_joint - p.joint_of_best));
      sum += s.probability;
    }
    for (SetPosterior& s : p.sets) {
      s.probability /= sum;
      if (s.hypotheses.empty()) p.probability_of_nothing = s.probability;
    }
    for (const SetMember& m : p.best.members) after.push_back(m.hypothesis);
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    if (before == after) break;
  }
  return out;
}

}  // namespace omniflight::diagnosis
