#include "inference.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "../evidence/first_stage.hpp"
#include "../evidence/tolerances.hpp"
#include "../numerics/parallel.hpp"
#include "grid_search.hpp"
#include "profile.hpp"

namespace omniflight::diagnosis {
namespace {

/// Times at most that the noise is estimated beside the best set so far: laws that are not linear, and
/// whatever else is not a slow function of place, count as noise until they are known.
constexpr int kRounds = 6;
constexpr double kNear = 10;          ///< nat: what a point of a grid may be behind
constexpr std::size_t kLaws = 6;      ///< that are asked in their own noise at once
constexpr std::size_t kPatterns = 1;  ///< of these
constexpr double kRival = 12;         ///< nat: rivals that are this far behind are asked in their own noise
constexpr double kWorth = 1e-3;       ///< nat

/// Drops what is not worth its place when the noise may take over what it does.
void without_idle_members(const Profiler& profiler, Profile& best) {
  while (!best.fit.members.empty()) {
    std::vector<std::vector<SetMember>> without(best.fit.members.size(), best.fit.members);
    for (std::size_t k = 0; k < without.size(); ++k)
      without[k].erase(without[k].begin() + static_cast<std::ptrdiff_t>(k));
    Profile better = profiler.best_of(without, best.tolerances);
    if (better.joint <= best.joint) return;
    best = std::move(better);
  }
}

/// A set loses by the noise of another one. Nothing at all, and the likeliest rivals, count in their own.
/// `nothing`: Profile::joint of the empty set.
void in_own_noise(const Profiler& profiler, double nothing, const Evidence& evidence, Posterior& p,
                  const Options& o) {
  const double log_scale = evidence.noise().log_scale() - evidence.noise().log_prior();
  std::vector<SetPosterior*> rivals;
  for (SetPosterior& s : p.sets) {
    if (s.hypotheses.empty())
      s.log_joint = std::max(s.log_joint, nothing + log_scale);
    else if (s.log_joint > p.joint_of_best - kRival && rivals.size() < kTried)
      rivals.push_back(&s);
  }
  parallel_for(
      rivals.size(), o.threads,
      [&](std::size_t k) {
        SetPosterior& s = *rivals[k];
        s.log_joint = std::max(s.log_joint, profiler.of(s.members, evidence.tolerances()).joint + log_scale);
      },
      o.stop);
  share_probability(o.assumes(Assumption::resolution) ? o.law_error : 0.0, p);
}

/// Gains of hypotheses that were never fitted alone.
void add_unfitted(const GridSearch& grid, const std::vector<Hypothesis>& hypotheses, Posterior& p) {
  std::set<int> fitted;
  for (const auto& [hypothesis, gain] : p.alone) fitted.insert(hypothesis);
  const auto all = grid.additions(p.nothing);
  for (const auto* candidates : {&all.laws, &all.patterns})
    for (const Candidate& c : *candidates) {
      const int h = c.member.hypothesis;
      if (fitted.insert(h).second)
        p.alone.emplace_back(h, c.gain - hypotheses[static_cast<std::size_t>(h)].log_odds);
    }
}

}  // namespace

Eigen::VectorXd wrench_of_set(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
                              const SetFit& set, States states) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(problem.rows()), value;
  for (const SetMember& member : set.members) {
    const Hypothesis& h = hypotheses[static_cast<std::size_t>(member.hypothesis)];
    if (states == States::predicted || h.pattern) {
      sum += expected_wrench(problem, h, member);
      continue;
    }
    problem.wrench_of({h.effect, member.theta, member.start}, value, nullptr, nullptr, states);
    sum += value;
  }
  return sum;
}

namespace {

std::vector<EffectTerm> terms_of(const std::vector<SetMember>& laws,
                                 const std::vector<const physics::Effect*>& effects) {
  std::vector<EffectTerm> out;
  for (const SetMember& m : laws)
    out.push_back({effects[static_cast<std::size_t>(m.hypothesis)], m.theta, m.start});
  return out;
}

/// The inference at one horizon, in steps: one that is refused is not finished.
class Inferrer {
 public:
  /// Searches once, in the noise that slow functions of place leave. `seed`: laws that were found at another
  /// horizon.
  Inferrer(std::unique_ptr<RegressionProblem> problem, const std::vector<const physics::Effect*>& effects,
           const Options& o, std::vector<SetMember> seed)
      : effects_(effects), o_(o), seed_(std::move(seed)) {
    out_.problem = std::move(problem);
    if (!seed_.empty()) out_.problem->expect(terms_of(seed_, effects));
    slow_ = slow_columns(*out_.problem);
    limits_.threads = o.threads;
    limits_.stop = o.stop;
    limits_.most_members = 8;
    limits_.load_starts = o.assumes(Assumption::load_starts);
    auto first = estimate_noise(*out_.problem, slow_, Eigen::VectorXd::Zero(out_.problem->rows()),
                                out_.problem->temperature(), ToldShape::as_told);
    out_.problem->scale_calibration(first_stages(first->apply(out_.problem->calibration().columns),
                                                 first->apply(out_.problem->calibration().measured)));
    fitted_.emplace(*out_.problem);
    profiler_.emplace(*out_.problem, out_.hypotheses, slow_, *fitted_, o);
    current_ = profiler_->of({}, Eigen::VectorXd::Ones(out_.problem->calibration().settled.size()));
    nothing_ = current_.joint;
    search_in(std::move(first), current_.tolerances, {});
  }

  /// Searches again in the noise that the best set leaves, until nothing is gained.
  void improve() {
    for (int round = 0; round < kRounds && !o_.stopped(); ++round) {
      const auto tried = worth_their_own_noise(round == 0);
      if (tried.empty()) break;
      Profile best = profiler_->best_of(tried, current_.tolerances);
      without_idle_members(*profiler_, best);
      if (!(best.joint > current_.joint + kWorth)) break;
      current_ = std::move(best);
      if (!out_.problem->expects(current_.expected)) {
        out_.problem->expect(current_.expected);
        prepare_again(*out_.problem, *current_.noise, o_.threads, out_.hypotheses);
        for (SetMember& m : current_.fit.members) m.first_stage.reset();
      }
      search_in(std::move(current_.noise), current_.tolerances, current_.fit.members);
    }
  }

  /// Wrench of the best set and of the calibration beside it, at measured states.
  Eigen::VectorXd known() const {
    const SetFit& best = out_.posterior.best;
    return wrench_of_set(*out_.problem, out_.hypotheses, best, States::measured) +
           out_.problem->calibration().measured * best.calibration;
  }

  /// Laws of the best set.
  std::vector<SetMember> laws() const {
    std::vector<SetMember> out;
    for (const SetMember& m : out_.posterior.best.members)
      if (static_cast<std::size_t>(m.hypothesis) < effects_.size()) {  // patterns come behind the laws
        out.push_back(m);
        out.back().first_stage.reset();
      }
    return out;
  }

  Inference finish() {
    out_.posterior.energy =
        found_->noise()
            .apply(wrench_of_set(*out_.problem, out_.hypotheses, out_.posterior.best, States::predicted))
            .array()
            .square();
    out_.posterior.probability_of_error = probability_of_errors(
        o_.law_error, out_.posterior.energy, out_.posterior.best.rest.array(), out_.problem->temperature());
    in_own_noise(*profiler_, nothing_, *found_, out_.posterior, o_);
    add_unfitted(*grid_, out_.hypotheses, out_.posterior);
    return std::move(out_);
  }

 private:
  void search_in(std::unique_ptr<NoiseModel> noise, const Eigen::VectorXd& tolerances,
                 const std::vector<SetMember>& first_asked) {
    if (out_.hypotheses.empty())
      out_.hypotheses = make_hypotheses(*out_.problem, *noise, effects_, o_);
    else
      whiten(*noise, o_.threads, out_.hypotheses);
    found_ = std::make_unique<Evidence>(*out_.problem, *fitted_, *noise, out_.hypotheses, o_.error_of_laws(),
                                        tolerances);
    out_.noise = std::move(noise);
    out_.tolerances = tolerances;
    grid_ = std::make_unique<GridSearch>(*found_, limits_);
    out_.posterior = search(*found_, *grid_, limits_, first_asked);
  }

  bool has_pattern(const std::vector<SetMember>& members) const {
    return std::any_of(members.begin(), members.end(), [&](const SetMember& m) {
      return out_.hypotheses[static_cast<std::size_t>(m.hypothesis)].pattern != nullptr;
    });
  }

  /// What the search found, and what may come out only when the noise no longer contains it.
  std::vector<std::vector<SetMember>> worth_their_own_noise(bool first_round) {
    std::vector<std::vector<SetMember>> tried;
    if (first_round && !seed_.empty()) tried.push_back(seed_);
    for (const SetPosterior& rival : out_.posterior.sets)
      if (rival.log_joint > out_.posterior.joint_of_best - kRival && tried.size() < kTried)
        tried.push_back(rival.members);
    // in noise that contains them laws may be far behind a pattern that does what they do
    const auto laws =
        std::find_if(out_.posterior.sets.begin(), out_.posterior.sets.end(),
                     [&](const SetPosterior& s) { return !s.hypotheses.empty() && !has_pattern(s.members); });
    if (laws != out_.posterior.sets.end() && laws->log_joint <= out_.posterior.joint_of_best - kRival)
      tried.push_back(laws->members);
    const Evidence tight(*out_.problem, *fitted_, *out_.noise, out_.hypotheses, o_.error_of_laws(),
                         o_.assumes(Assumption::tolerance_factors)
                             ? tightest_tolerances(out_.problem->calibration())
                             : current_.tolerances);
    std::set<int> asked;
    for (const Evidence* evidence : {static_cast<const Evidence*>(found_.get()), &tight}) {
      const SetFit here = evidence->fit(current_.fit.members);
      auto more = grid_->additions(here, GridSearch::Noise::own);
      more.laws.resize(std::min(more.laws.size(), kLaws));
      more.patterns.resize(std::min(more.patterns.size(), kPatterns));
      for (auto* candidates : {&more.laws, &more.patterns})
        for (Candidate& c : *candidates) {
          if (c.gain < -kNear || !asked.insert(c.member.hypothesis).second) continue;
          tried.push_back(here.members);
          tried.back().push_back(std::move(c.member));
        }
    }
    return tried;
  }

  const std::vector<const physics::Effect*>& effects_;
  const Options& o_;
  std::vector<SetMember> seed_;
  Inference out_;
  SlowColumns slow_;
  SearchLimits limits_;
  std::optional<FittedAmplitudes> fitted_;
  std::optional<Profiler> profiler_;
  Profile current_;
  double nothing_ = 0;               ///< Profile::joint of the empty set
  std::unique_ptr<Evidence> found_;  ///< in the noise that the best set so far leaves
  std::unique_ptr<GridSearch> grid_;
};

}  // namespace

Inference infer(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                const std::vector<const physics::Effect*>& effects, const Options& o) {
  const Horizons horizons(flights, vehicle, o);
  HorizonChoice choice;
  const auto refused = [&](HorizonTest test) {
    choice.tests.push_back(std::move(test));
    return o.assumes(Assumption::horizons) && !choice.tests.back().agrees() && !o.stopped();
  };
  std::vector<SetMember> seed;
  for (std::size_t k = 0;; ++k) {
    const bool doubted = refused(horizons.test(k));
    Inferrer here(horizons.problem(k), effects, o, std::move(seed));
    here.improve();
    const std::vector<EffectTerm> found = terms_of(here.laws(), effects);
    if ((!doubted && found.empty()) || !refused(horizons.test(k, here.known(), found))) {
      Inference out = here.finish();
      out.horizon = std::move(choice);
      return out;
    }
    seed = here.laws();
  }
}

}  // namespace omniflight::diagnosis
