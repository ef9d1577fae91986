#include "answer.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "../regression/channels.hpp"
#include "../search/single_rotor.hpp"
#include "dependence.hpp"
#include "unknown_physics.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, see docs/explanation/diagnosis_method.md, Numbers that are chosen.
constexpr double kCredible = 0.95;  ///< posterior mass of a credible set
/// Posterior probability from which on the verdict takes a question as decided
constexpr double kExplained = 0.8;
/// Posterior over prior standard deviation from which on a flight does not inform a parameter.
constexpr double kUninformed = 0.95;
constexpr std::size_t kShownSets = 50;   ///< the likeliest
const std::string kUnknown = "unknown";  ///< name of any pattern outside the library

/// Ids of the effects; single-rotor hypotheses of one effect are one id.
std::set<std::string> names_of(const Inference& in, const std::vector<int>& hypotheses) {
  std::set<std::string> out;
  for (const int h : hypotheses) {
    const Hypothesis& x = in.hypotheses[static_cast<std::size_t>(h)];
    out.insert(x.pattern ? kUnknown : x.id);
  }
  return out;
}

/// Posterior probability of each set of ids, of the empty one and the candidates.
std::map<std::set<std::string>, double> by_names(const Inference& in) {
  std::map<std::set<std::string>, double> out;
  for (const SetPosterior& s : in.posterior.sets)
    if (s.hypotheses.empty() || in.posterior.is_candidate(s))
      out[names_of(in, s.hypotheses)] += s.probability;
  return out;
}

/// Effects that replace `id` in sets without it, most probable first, until sets with `id` or these hold
/// kCredible.
std::vector<std::string> replacements(const std::map<std::set<std::string>, double>& sets,
                                      const std::set<std::string>& named, const std::string& id) {
  std::map<std::string, double> mass;
  double with = 0, total = 0;
  for (const auto& [names, p] : sets) {
    total += p;
    if (names.contains(id)) {
      with += p;
      continue;
    }
    std::vector<std::string> others;
    for (const std::string& name : names)
      if (!named.contains(name)) others.push_back(name);
    for (const std::string& name : others) mass[name] += p / static_cast<double>(others.size());
  }
  std::vector<std::pair<double, std::string>> sorted;
  for (const auto& [name, p] : mass) sorted.emplace_back(p, name);
  std::sort(sorted.rbegin(), sorted.rend());
  std::vector<std::string> out;
  for (const auto& [p, name] : sorted) {
    if (with >= kCredible * total || p < 0.01) break;
    out.push_back(name);
    with += p;
  }
  return out;
}

Finding finding_of(const Inference& in, const SetMember& member,
                   const std::map<std::set<std::string>, double>& sets, const std::set<std::string>& named) {
  const Hypothesis& h = in.hypotheses[static_cast<std::size_t>(member.hypothesis)];
  const physics::EffectInfo& info = h.effect->info();
  Finding f;
  f.effect = info.id;
  f.stage = info.stage;
  f.equation = info.equation;
  f.latex = info.latex;
  f.probability = in.posterior.inclusion(h.id, in.hypotheses);
  f.cannot_be_told_apart_from = replacements(sets, named, info.id);
  f.rivals = static_cast<int>(f.cannot_be_told_apart_from.size());
  std::string values;
  for (std::size_t k = 0; k < member.theta.size(); ++k) {
    const physics::Parameter& p = info.parameters[k];
    const double value = member.theta[k];
    const double deviation = deviation_over_sets(in.posterior, in.hypotheses, member.hypothesis, k, value);
    const double half = 1.96 * deviation;
    double low = value - half, high = value + half;
    const physics::ParameterPrior prior = in.problem->prior(*h.effect, k);
    if (prior.law == physics::ParameterPrior::Law::log_normal) {
      const double factor = std::exp(half / std::max(1e-12, value));
      low = value / factor;
      high = value * factor;
    }
    if (deviation >= kUninformed * std::abs(prior.slope(prior.coordinate(value)))) {
      low = p.lower;
      high = p.upper;
    }
    f.parameters.push_back(
        {p.name, p.symbol, p.unit, value, std::max(p.lower, low), std::min(p.upper, high)});
    if (!identifiable(info.id, f.parameters.back())) {
      values += (values.empty() ? "" : ", ") + p.name + " not identifiable";
      continue;
    }
    values +=
        format("%s%s = %.4g %s (95 %%: %.4g to %.4g)", values.empty() ? "" : ", ", p.name.c_str(), value,
               p.unit == "1" ? "" : p.unit.c_str(), f.parameters.back().low, f.parameters.back().high);
  }
  f.sentence = info.term + ": " + values + ".";
  if (f.rivals > 0) {
    f.sentence += " On this flight it cannot be told apart from";
    for (const std::string& id : f.cannot_be_told_apart_from) f.sentence += " " + id;
    if (!info.separated_by.empty()) f.sentence += "; " + info.separated_by + " would tell";
    f.sentence += ".";
  }
  return f;
}

/// Windows [s] of the first flight in which the RMS of x over 1 s exceeds `level`.
std::vector<std::pair<double, double>> windows_above(const RegressionProblem& problem,
                                                     const Eigen::VectorXd& x, double level) {
  std::vector<std::pair<double, double>> out;
  const int half = static_cast<int>(0.5 / problem.period());
  for (const Stretch& s : problem.stretches()) {
    if (s.flight != 0) break;
    bool open = false;
    for (int i = s.begin; i < s.end; ++i) {
      const int a = std::max(s.begin, i - half), b = std::min(s.end, i + half + 1);
      const bool above = rms(x.segment(a, b - a)) > level;
      const double t = problem.situation(i).t;
      if (above && !open) out.emplace_back(t, t);
      if (above) out.back().second = t;
      open = above;
    }
  }
  return out;
}

void add_mismatch(const Inference& in, const Eigen::VectorXd& wrench, const Eigen::VectorXd& rest,
                  Diagnosis& d) {
  const RegressionProblem& problem = *in.problem;
  const int n = problem.samples();
  const std::vector<StateVariable> variables = state_variables(problem);
  for (int c = 0; c < 6; ++c) {
    const Eigen::VectorXd own = wrench.segment(c * n, n);
    const Eigen::VectorXd left = rest.segment(c * n, n);
    if (rms(own) < 0.2 * rms(left) && rms(own) < 1e-3 * problem.scale(c)) continue;
    if (rms(own) < 0.1 * rms(left)) continue;
    Mismatch m;
    m.channel = kChannels[static_cast<std::size_t>(c)];
    m.unit = channel_unit(c);
    m.frame = "body";
    m.rms = rms(problem.residual().segment(c * n, n));
    m.noise_rms = rms(left);
    m.p_value = in.posterior.probability_of_nothing;
    m.where = dependence_of(problem.residual().segment(c * n, n), variables, channel_unit(c), m.noise_rms);
    m.windows_s = windows_above(problem, own, 0.5 * rms(own));
    d.mismatch.push_back(std::move(m));
  }
}

void add_remaining(const Inference& in, const Eigen::VectorXd& rest, Diagnosis& d) {
  const RegressionProblem& problem = *in.problem;
  const Impulses& impulses = in.noise->impulses();
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c) {
    Eigen::VectorXd x = rest.segment(c * n, n);
    if (x.isZero(0)) continue;
    Remaining out{kChannels[static_cast<std::size_t>(c)], channel_unit(c)};
    if (impulses.count > 0) {
      x -= impulses.wrench.segment(c * n, n);
      const auto sizes = impulses.sizes.segment(c * n, n).array().abs();
      Eigen::Index largest = 0;
      out.lone_samples = static_cast<int>((sizes != 0).count());
      out.largest_lone_sample = sizes.maxCoeff(&largest);
      if (out.lone_samples > 0) out.largest_at_s = problem.measured(static_cast<int>(largest)).t;
    }
    // power beyond that of white noise at the level of high frequencies: coloured noise, or physics not found
    out.rms = rms(x);
    out.noise_rms = in.noise->fast_part(c);
    out.predictable_share =
        std::max(0.0, 1 - std::pow(out.noise_rms, 2) / std::max(1e-300, x.squaredNorm() / n));
    d.remaining.push_back(std::move(out));
  }
}

/// Direct where regressors of the shortest horizon agree with longer ones; longer ones are instruments.
EstimatorChoice estimator_of(const HorizonChoice& horizon) {
  const HorizonTest& chosen = horizon.tests.back();
  const Horizon &first = horizon.tests.front().horizon, &last = chosen.horizon;
  const bool direct = first.s == last.s && first.reference_alone == last.reference_alone;
  std::string reason = format("regressors are predicted %.3g s ahead", last.s);
  if (last.reference_alone) reason += " by the reference alone";
  if (chosen.compared > 0)
    reason += format("; their estimates agree with those of longer horizons (largest statistic %.3g of %.3g)",
                     chosen.statistic, chosen.threshold());
  else
    reason += ", the longest horizon that was asked";
  if (!direct) reason += "; shorter ones disagreed, so feedback biases them";
  return {direct ? "direct" : "instrumental", reason};
}

void add_decisions(const Inference& in, const std::set<std::string>& named, Diagnosis& d) {
  std::map<std::string, double> gain, odds;
  for (const auto& [hypothesis, g] : in.posterior.alone) {
    const Hypothesis& h = in.hypotheses[static_cast<std::size_t>(hypothesis)];
    const std::string name = h.pattern ? "unknown: " + h.pattern->variable : h.id;
    if (const auto at = gain.find(name); at == gain.end() || at->second < g) {
      gain[name] = g;
      odds[name] = h.log_odds;
    }
  }
  for (const HorizonTest& t : in.horizon.tests)
    d.decisions.push_back(
        {format("horizon %.3f s%s", t.horizon.s, t.horizon.reference_alone ? ", reference alone" : ""),
         std::string("estimates against those of longer horizons") +
             (t.beside_found ? ", beside what was found" : "") + (t.about.empty() ? "" : ", " + t.about),
         t.statistic, t.threshold(), "Hausman's test, chi-square of one degree of freedom",
         t.agrees() ? "agrees" : "disagrees: feedback, or what is left out, biases it"});
  const auto& between = in.posterior.left_between_laws;
  const auto left = [&](const std::string& about, double nat) {
    d.decisions.push_back({about, "what they leave of the largest gain", nat, 0,
                           "their energy over the noise, of each amplitude no more than is left there",
                           "differences of ln evidence are divided by one plus it"});
  };
  left("errors of laws, against nothing", in.posterior.left_by_laws);
  for (std::size_t k = 0; k < between.size(); ++k)
    left(format("errors of laws, %.0f times as large, between laws (%.2f)", kRivalErrors[k],
                in.posterior.probability_of_error[k]),
         between[k]);
  const Calibration& c = in.problem->calibration();
  std::set<std::string> listed;
  for (std::size_t k = 0; k < c.kinds.size(); ++k)
    if (c.settled[static_cast<Eigen::Index>(k)] < 1 && listed.insert(c.kinds[k]).second)
      d.decisions.push_back({"tolerance: " + c.kinds[k], "factor on what is assumed where nothing is told",
                             in.tolerances[static_cast<Eigen::Index>(k)], 1,
                             "empirical Bayes by kinds of calibration", "as the flight shows it"});
  for (const auto& [name, g] : gain) {
    const double p = in.posterior.inclusion(name, in.hypotheses);
    d.decisions.push_back({name, "evidence alone against nothing", g, -odds[name],
                           "log Bayes factor against prior odds of inclusion",
                           named.contains(name) ? format("kept, posterior inclusion %.3f", p)
                                                : format("refused, posterior inclusion %.3f", p)});
    d.candidates.push_back({name, g, -odds[name]});
  }
}

void add_sets(const Inference& in, Diagnosis& d) {
  const std::vector<SetPosterior>& sets = in.posterior.sets;
  double nothing = 0;
  std::vector<const SetPosterior*> likeliest;
  for (const SetPosterior& s : sets) {
    likeliest.push_back(&s);
    if (s.hypotheses.empty()) nothing = s.log_joint;
  }
  std::stable_sort(likeliest.begin(), likeliest.end(),
                   [](const auto* a, const auto* b) { return a->probability > b->probability; });
  for (const SetPosterior* s : likeliest) {
    if (d.sets.size() == kShownSets) break;
    d.sets.push_back({{}, s->log_joint - s->log_prior - nothing, s->log_prior, s->probability});
    for (const int h : s->hypotheses) {
      const Hypothesis& x = in.hypotheses[static_cast<std::size_t>(h)];
      d.sets.back().effects.push_back(x.pattern ? kUnknown + ": " + x.pattern->variable : x.id);
    }
  }
}

void add_series(const Inference& in, std::span<const Flight* const> flights, const Eigen::VectorXd& rest,
                Diagnosis& d) {
  const RegressionProblem& problem = *in.problem;
  const int n = problem.samples();
  for (std::size_t k = 0; k < flights.size(); ++k) {
    Series s;
    s.file = flights[k]->file;
    for (const char* c : kChannels) s.channels.emplace_back(c);
    s.channels.emplace_back("Fz_world");
    s.before.resize(7);
    s.after.resize(7);
    for (const Stretch& part : problem.stretches()) {
      if (part.flight != static_cast<int>(k)) continue;
      for (int i = part.begin; i < part.end; ++i) {
        const physics::Situation& x = problem.situation(i);
        s.t_s.push_back(x.t);
        s.height_m.push_back(x.body.p_WB.z());
        Vec3 before, after;
        for (int c = 0; c < 6; ++c) {
          const double b = problem.residual()[c * n + i], a = rest[c * n + i];
          s.before[static_cast<std::size_t>(c)].push_back(b);
          s.after[static_cast<std::size_t>(c)].push_back(a);
          if (c < 3) before[c] = b, after[c] = a;
        }
        s.before[6].push_back(x.R_WB.row(2).dot(before));
        s.after[6].push_back(x.R_WB.row(2).dot(after));
      }
    }
    d.series.push_back(std::move(s));
  }
}

/// Whether sets with all of `named` hold kExplained, and no further effect of the library has more than 1 -
/// kExplained. Patterns outside the library do not count here.
bool is_decided(const std::map<std::set<std::string>, double>& sets, const std::set<std::string>& named) {
  double hold = 0, total = 0;
  std::map<std::string, double> further;
  for (const auto& [names, probability] : sets) {
    total += probability;
    if (std::includes(names.begin(), names.end(), named.begin(), named.end())) hold += probability;
    for (const std::string& name : names)
      if (!named.contains(name) && name != kUnknown) further[name] += probability;
  }
  return hold >= kExplained * total && std::all_of(further.begin(), further.end(), [&](const auto& x) {
           return x.second <= (1 - kExplained) * total;
         });
}

}  // namespace

void add_posterior(const Inference& in, const SetFit& fit, std::span<const Flight* const> flights,
                   Diagnosis& d) {
  const RegressionProblem& problem = *in.problem;
  const int n = problem.samples();
  const Eigen::VectorXd wrench = wrench_of_set(problem, in.hypotheses, fit, States::measured);
  const Eigen::VectorXd rest = problem.residual() - wrench - problem.calibration().measured * fit.calibration;
  const auto candidates = by_names(in);
  std::vector<int> members;
  for (const SetMember& m : fit.members) members.push_back(m.hypothesis);
  const std::set<std::string> named = names_of(in, members);
  const bool something = !members.empty();
  for (const SetMember& member : fit.members) {
    const Hypothesis& h = in.hypotheses[static_cast<std::size_t>(member.hypothesis)];
    if (h.pattern) {
      d.unexplained.push_back(unexplained_of(in, member, problem.residual()));
      for (const CorrectionTerm& term : d.unexplained.back().correction)
        if (term.model) d.model.push_back(physics::as_effect(*term.model));
      continue;
    }
    Finding f = finding_of(in, member, candidates, named);
    Eigen::VectorXd value;
    problem.wrench_of({h.effect, member.theta, member.start}, value, nullptr, nullptr, States::measured);
    for (int c = 0; c < 6; ++c)
      if (rms(value.segment(c * n, n)) > 0.2 * rms(rest.segment(c * n, n)))
        f.channels.emplace_back(kChannels[static_cast<std::size_t>(c)]);
    const physics::ActiveEffect whole = in_full({h.effect, member.theta});
    const auto same = std::find_if(d.model.begin(), d.model.end(),
                                   [&](const physics::ActiveEffect& m) { return m.effect == whole.effect; });
    if (same == d.model.end()) {
      d.model.push_back(whole);
      d.findings.push_back(std::move(f));
    } else {  // two rotors of one effect are one finding
      for (std::size_t p = 0; p < whole.theta.size(); ++p)
        same->theta[p] += whole.theta[p] - whole.effect->info().parameters[p].neutral;
      for (Finding& known : d.findings)
        if (known.effect == f.effect) {
          known.parameters.insert(known.parameters.end(), f.parameters.begin(), f.parameters.end());
          known.sentence += " " + f.sentence;
        }
    }
  }
  d.probability_of_nothing = in.posterior.probability_of_nothing;
  if (something) add_mismatch(in, wrench, rest, d);
  add_remaining(in, rest, d);
  add_decisions(in, named, d);
  add_sets(in, d);
  d.estimator = estimator_of(in.horizon);
  add_series(in, flights, rest, d);
  for (int c = 0; c < 6; ++c)
    d.fit.in_sample.push_back({"", kChannels[static_cast<std::size_t>(c)], channel_unit(c),
                               rms(problem.residual().segment(c * n, n)), rms(rest.segment(c * n, n))});
  if (!something)
    d.verdict = Verdict::nothing_missing;
  else if (!d.unexplained.empty())
    d.verdict = Verdict::unexplained;
  else
    d.verdict = is_decided(candidates, named) ? Verdict::explained : Verdict::ambiguous;
}

}  // namespace omniflight::diagnosis
