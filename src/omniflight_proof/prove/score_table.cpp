// The table of the proof: what is counted over which cases, with must and goal.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "score.hpp"

namespace omniflight::proof {
namespace {

struct Pair {
  const Truth* truth;
  const Answer* answer;
  Judged judged;
  double least_seen = 0;  ///< of the weakest effect by an oracle, see least_seen(); NaN: not asked
};
using Cases = std::vector<Pair>;
using Choice = std::function<bool(const Pair&)>;

constexpr double kSize = 0.3 - 1e-9;  ///< sigma from which an effect has to be found
constexpr double kSeen = 5.5;         ///< standard errors from which an oracle sees an effect well

/// How far the weakest effect of an answer is from nothing, all its numbers together, in standard errors. NaN
/// where none has numbers.
double least_seen(const Answer& oracle) {
  constexpr double kWidth = 2 * 1.96;  // of an interval, in standard errors
  double least = std::nan("");
  for (const AnsweredEffect& e : oracle.findings) {
    double squares = 0;
    for (const AnsweredParameter& p : e.parameters)
      squares += std::pow(p.value * kWidth / std::max(1e-300, p.high - p.low), 2);
    if (!e.parameters.empty()) least = std::fmin(least, std::sqrt(squares));
  }
  return least;
}

Score rate(const Cases& cases, std::string name, std::string over, const Choice& counts, const Choice& good,
           double must, double goal, bool smaller = false) {
  Score s{.name = std::move(name), .over = std::move(over)};
  for (const Pair& p : cases)
    if (counts(p)) {
      ++s.n;
      s.k += good(p);
    }
  s.value = s.n > 0 ? static_cast<double>(s.k) / s.n : std::nan("");
  s.interval = wilson(s.k, s.n);
  if (must < 0) return s;  // information
  s.must = fmt::format("{} {:g} %", smaller ? "<=" : ">=", 100 * must);
  s.goal = fmt::format("{} {:g} %", smaller ? "<=" : ">=", 100 * goal);
  const auto meets = [&](double bound) { return smaller ? s.value <= bound : s.value >= bound; };
  s.verdict = s.n == 0      ? Score::Verdict::not_judged
              : meets(goal) ? Score::Verdict::goal
              : meets(must) ? Score::Verdict::must
                            : Score::Verdict::short_of;
  return s;
}

Score number(std::string name, std::string over, std::string unit, const std::vector<double>& values,
             double value, double must, double goal, bool smaller) {
  Score s{.name = std::move(name),
          .over = std::move(over),
          .n = static_cast<int>(values.size()),
          .is_rate = false};
  s.unit = std::move(unit);
  s.value = values.empty() ? std::nan("") : value;
  s.must = fmt::format("{} {:g} {}", smaller ? "<=" : ">=", must, s.unit);
  s.goal = fmt::format("{} {:g} {}", smaller ? "<=" : ">=", goal, s.unit);
  const auto meets = [&](double bound) { return smaller ? s.value <= bound : s.value >= bound; };
  s.verdict = values.empty() ? Score::Verdict::not_judged
              : meets(goal)  ? Score::Verdict::goal
              : meets(must)  ? Score::Verdict::must
                             : Score::Verdict::short_of;
  return s;
}

bool hidden(const Pair& p) { return !p.truth->effects.empty(); }
bool designed(const Pair& p) { return p.truth->flight == "designed"; }
bool large(const Pair& p) { return p.truth->magnitude >= kSize; }
bool named(const Pair& p) { return hidden(p) && p.truth->kind != Kind::unknown; }
bool single(const Pair& p) { return p.truth->kind == Kind::single; }

/// A rate within [low, high] is what coverage asks for.
Score coverage(Score s) {
  s.must = "88 to 99 %";
  s.goal = "92 to 98 %";
  const auto in = [&](double a, double b) { return s.value >= a && s.value <= b; };
  s.verdict = s.n == 0         ? Score::Verdict::not_judged
              : in(0.92, 0.98) ? Score::Verdict::goal
              : in(0.88, 0.99) ? Score::Verdict::must
                               : Score::Verdict::short_of;
  return s;
}

void parameters(const Cases& cases, std::vector<Score>& table) {
  std::vector<double> errors;
  Score covered{.name = "95 % interval covers",
                .over = "parameters of single effects named right, >= 0.3 sigma, designed"};
  for (const Pair& p : cases) {
    if (!single(p) || !large(p) || !designed(p)) continue;
    const TrueEffect& e = p.truth->effects[0];
    for (const auto& f : p.answer->findings)
      if (f.id == e.id)
        for (const auto& truth : e.parameters)
          for (const auto& said : f.parameters)
            if (said.name == truth.name && truth.scale > 0 && std::isfinite(said.value)) {
              errors.push_back(std::abs(said.value - truth.value) / truth.scale);
              ++covered.n;
              covered.k += said.low <= truth.value && truth.value <= said.high;
            }
  }
  table.push_back(
      number("parameter error, median", covered.over, "%", errors, 100 * median(errors), 7, 3, true));
  covered.value = covered.n > 0 ? static_cast<double>(covered.k) / covered.n : std::nan("");
  covered.interval = wilson(covered.k, covered.n);
  table.push_back(coverage(covered));
}

void fits(const Cases& cases, std::vector<Score>& table) {
  std::vector<double> shares, power;
  int axes = 0, good = 0, better = 0;
  for (const Pair& p : cases) {
    if (named(p) && large(p) && designed(p) && p.truth->effects[0].stage == "wrench") {
      // no answer explains nothing
      if (std::isfinite(p.judged.explained))
        shares.push_back(std::clamp(p.judged.explained, 0.0, 1.0));
      else if (p.judged.refused)
        shares.push_back(0.0);
    }
    for (const auto& c : p.answer->closed_loop)
      if (hidden(p) && c.real > 0 && std::isfinite(c.after)) {
        const double r = c.after / c.real;
        ++axes;
        good += r >= 0.67 && r <= 1.5;
        better += r >= 0.8 && r <= 1.25;
      }
    if (hidden(p) && p.answer->power_real > 0 && std::isfinite(p.answer->power_after))
      power.push_back(std::abs(p.answer->power_after / p.answer->power_real - 1));
  }
  table.push_back(number("held-out residual explained, of oracle, median",
                         "wrench effects, >= 0.3 sigma, designed; energy of the true effect = 100 %", "%",
                         shares, 100 * median(shares), 80, 90, false));
  Score loop{.name = "closed-loop RMSE ratio per axis in [0.67, 1.5]",
             .over = "axes of cases that were flown again",
             .k = good,
             .n = axes};
  loop.value = axes > 0 ? static_cast<double>(good) / axes : std::nan("");
  loop.interval = wilson(good, axes);
  loop.must = "all in [0.67, 1.5]";
  loop.goal = "all in [0.8, 1.25]";
  loop.verdict = axes == 0        ? Score::Verdict::not_judged
                 : better == axes ? Score::Verdict::goal
                 : good == axes   ? Score::Verdict::must
                                  : Score::Verdict::short_of;
  table.push_back(loop);
  table.push_back(number("power ratio after, median error", "cases that were flown again", "%", power,
                         100 * median(power), 4, 2, true));
}

/// Single effects that an answer could not tell apart from others, and a flight was proposed: is it told by
/// both flights together? A proposal that could not be flown resolves nothing.
void resolved(const Cases& cases, const std::map<std::string, Answer>& second, const std::string& last_asked,
              std::vector<Score>& table) {
  const auto ambiguous = [&](const Pair& p) {
    return (last_asked.empty() || p.truth->id <= last_asked) && single(p) && large(p) &&
           p.judged.set_size > 1 && p.judged.covered && p.answer->proposes;
  };
  const auto then = [&](const Pair& p) {
    const auto found = second.find(p.truth->id);
    return found == second.end() ? nullptr : &found->second;
  };
  table.push_back(rate(
      cases, "ambiguity resolved by the one proposed flight",
      "single effects, >= 0.3 sigma, truth in a set of several, a flight proposed", ambiguous,
      [&](const Pair& p) {
        const Answer* a = then(p);
        const Judged j = a ? judge(*p.truth, *a) : Judged{};
        return j.top1 && j.set_size == 1;
      },
      0.75, 0.90));
  table.push_back(rate(
      cases, "  top-1 with both flights", "the same", ambiguous,
      [&](const Pair& p) {
        const Answer* a = then(p);
        return a && judge(*p.truth, *a).top1;
      },
      -1, -1));
  table.push_back(rate(
      cases, "  top-1 before", "the same", ambiguous, [](const Pair& p) { return p.judged.top1; }, -1, -1));
}

}  // namespace

std::string to_string(Score::Verdict v) {
  switch (v) {
    case Score::Verdict::goal:
      return "goal met";
    case Score::Verdict::must:
      return "must met";
    case Score::Verdict::short_of:
      return "short of must";
    case Score::Verdict::not_judged:
      return "not judged";
    case Score::Verdict::information:
      break;
  }
  return "information";
}

Scores score(const std::vector<Truth>& truths, const std::map<std::string, Answer>& answers,
             const std::map<std::string, Answer>& second, const std::map<std::string, Answer>& oracle,
             const std::string& last_asked) {
  static const Answer none{.problem = "there is no answer"};
  Scores out;
  Cases cases;
  for (const Truth& t : truths) {
    const auto found = answers.find(t.id);
    const Answer& a = found == answers.end() ? none : found->second;
    const auto told = oracle.find(t.id);
    cases.push_back({&t, &a, judge(t, a), told == oracle.end() ? std::nan("") : least_seen(told->second)});
    const Judged& j = cases.back().judged;
    out.cases.push_back(j);
    if (t.kind == Kind::single || t.effects.empty() || t.kind == Kind::unknown) {
      const Answer clean = without_nuisances(t, a);
      const std::string truth = t.effects.empty() ? "nothing" : t.effects[0].id;
      const std::string said = j.refused                 ? "no answer"
                               : !clean.findings.empty() ? clean.findings.front().id
                               : !clean.unknown.empty()  ? "unknown"
                                                         : "nothing";
      ++out.confusion[truth][said];
    }
  }
  auto& t = out.table;
  const auto nominal = [](const Pair& p) { return !hidden(p); };
  t.push_back(rate(
      cases, "false alarms", "null and decoy flights", nominal, [](const Pair& p) { return p.judged.alarm; },
      0.03, 0.01, true));
  for (const char* flight : {"designed", "T2", "T1"})
    t.push_back(rate(
        cases, std::string("  of them on ") + flight, "null and decoy flights",
        [&](const Pair& p) { return !hidden(p) && p.truth->flight == flight; },
        [](const Pair& p) { return p.judged.alarm; }, -1, -1));
  t.push_back(rate(
      cases, "  of them decoys", "hard but nominal flights",
      [](const Pair& p) { return p.truth->kind == Kind::decoy; },
      [](const Pair& p) { return p.judged.alarm; }, -1, -1));
  t.push_back(rate(
      cases, "refused", "all cases: no answer, or called unusable", [](const Pair&) { return true; },
      [](const Pair& p) { return p.judged.refused; }, -1, -1));
  const auto found = [](const Pair& p) { return p.judged.detected; };
  t.push_back(rate(
      cases, "detection at >= 0.3 sigma", "cases with effects, designed flight",
      [](const Pair& p) { return hidden(p) && large(p) && designed(p); }, found, 0.95, 0.98));
  const auto told = [](const Pair& p) { return p.least_seen >= kSeen; };
  const std::string of_those = "  of those that an oracle sees well";
  const std::string well =
      fmt::format(", told what is hidden every effect is {:g} standard errors from nothing", kSeen);
  if (!oracle.empty())
    t.push_back(rate(
        cases, of_those, "the same" + well,
        [&](const Pair& p) { return hidden(p) && large(p) && designed(p) && told(p); }, found, -1, -1));
  for (const double m : {0.1, 0.3, 1.0})
    t.push_back(rate(
        cases, fmt::format("  at {:g} sigma", m), "cases with effects, any flight",
        [m](const Pair& p) { return hidden(p) && std::abs(p.truth->magnitude - m) < 0.05 * m; }, found, -1,
        -1));
  t.push_back(rate(
      cases, "right stage", "cases with effects, >= 0.3 sigma, designed flight",
      [](const Pair& p) { return hidden(p) && large(p) && designed(p); },
      [](const Pair& p) { return p.judged.stage; }, 0.95, 0.98));
  t.push_back(rate(
      cases, "  of those detected", "the same",
      [](const Pair& p) { return hidden(p) && large(p) && designed(p) && p.judged.detected; },
      [](const Pair& p) { return p.judged.stage; }, -1, -1));
  const auto one = [](const Pair& p) { return single(p) && large(p) && designed(p); };
  t.push_back(rate(
      cases, "right effect, top-1", "single effects, >= 0.3 sigma, designed flight", one,
      [](const Pair& p) { return p.judged.top1; }, 0.85, 0.95));
  for (const double m : {0.1, 0.3, 1.0})
    t.push_back(rate(
        cases, fmt::format("  at {:g} sigma", m), "single effects, designed flight",
        [m](const Pair& p) {
          return single(p) && designed(p) && std::abs(p.truth->magnitude - m) < 0.05 * m;
        },
        [](const Pair& p) { return p.judged.top1; }, -1, -1));
  for (const char* flight : {"T2", "T1"})
    t.push_back(rate(
        cases, std::string("  on ") + flight, "single effects, >= 0.3 sigma",
        [&](const Pair& p) { return single(p) && large(p) && p.truth->flight == flight; },
        [](const Pair& p) { return p.judged.top1; }, -1, -1));
  const auto stated = [&](const Pair& p) { return one(p) && p.judged.set_size > 0; };
  t.push_back(rate(
      cases, "truth inside the stated set", "single effects, >= 0.3 sigma, designed, a set is stated", stated,
      [](const Pair& p) { return p.judged.covered; }, 0.97, 0.99));
  std::vector<double> sizes;
  double sum = 0;
  for (const Pair& p : cases)
    if (stated(p)) {
      sizes.push_back(p.judged.set_size);
      sum += p.judged.set_size;
    }
  t.push_back(number("  mean size of the set", "the same", "effects", sizes,
                     sum / static_cast<double>(std::max<std::size_t>(1, sizes.size())), 2, 1.5, true));
  for (const char* flight : {"T2", "T1"})
    t.push_back(rate(
        cases, std::string("  inside it on ") + flight, "single effects, >= 0.3 sigma, a set is stated",
        [&](const Pair& p) {
          return single(p) && large(p) && p.judged.set_size > 0 && p.truth->flight == flight;
        },
        [](const Pair& p) { return p.judged.covered; }, -1, -1));
  const auto exact = [](const Pair& p) { return p.judged.exact; };
  const auto several = [&](const char* name, const char* over, Kind kind, double must, double goal) {
    const auto counts = [kind](const Pair& p) { return p.truth->kind == kind && designed(p); };
    t.push_back(rate(cases, name, over, counts, exact, must, goal));
    if (!oracle.empty())
      t.push_back(rate(
          cases, of_those, over + well, [&](const Pair& p) { return counts(p) && told(p); }, exact, -1, -1));
  };
  several("two effects exact", "pairs, designed flight", Kind::pair, 0.75, 0.90);
  several("three effects exact", "triples, designed flight", Kind::triple, 0.55, 0.75);
  t.push_back(rate(
      cases, "out of library: unknown, stage and variable right", "designed flight, >= 0.3 sigma",
      [](const Pair& p) { return p.truth->kind == Kind::unknown && designed(p) && large(p); }, exact, 0.80,
      0.90));
  t.push_back(rate(
      cases, "  called unknown, nothing named", "the same",
      [](const Pair& p) { return p.truth->kind == Kind::unknown && designed(p) && large(p); },
      [](const Pair& p) { return p.judged.top1; }, -1, -1));
  parameters(cases, t);
  fits(cases, t);
  resolved(cases, second, last_asked, t);
  return out;
}

}  // namespace omniflight::proof
