#include "family_scores.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace omniflight::proof {
namespace {

using Choice = std::function<bool(const FamilyJudged&)>;

bool named(const FamilyJudged& j) { return !j.nominal && j.truth->truth.kind != Kind::unknown; }
bool single(const FamilyJudged& j) { return j.truth->truth.kind == Kind::single; }
double sigma(const FamilyJudged& j) { return j.truth->truth.magnitude; }
/// Level of a size: what could not be made as large as wanted counts as the level below.
const char* level(const FamilyJudged& j) {
  return j.nominal          ? "none"
         : sigma(j) >= 2    ? "3 sigma"
         : sigma(j) >= 0.65 ? "1 sigma"
         : sigma(j) >= 0.2  ? "0.3 sigma"
                            : "below";
}

void add(GroupScores& g, const FamilyJudged& j) {
  ++g.cases;
  g.unanswered.count(!j.given);
  g.log_score += std::min(kWorstLog, -std::log(std::max(1e-9, j.true_probability)));
  if (j.nominal) {
    g.alarms.count(j.alarm);
    return;
  }
  g.detected.count(j.alarm);
  g.stage.count(j.stage);
  if (single(j)) g.top1.count(j.top1), g.covered.count(j.covered);
  if (j.truth->truth.kind == Kind::pair) g.pairs.count(j.exact);
  if (j.truth->truth.kind == Kind::triple) g.triples.count(j.exact);
  if (j.truth->truth.kind == Kind::unknown) g.unknown.count(j.unknown_right);
  g.intervals.n += j.intervals;
  g.intervals.k += j.intervals_hold;
}

GroupScores group(const std::vector<FamilyJudged>& cases, std::string axis, std::string value,
                  const Choice& in) {
  GroupScores g;
  g.axis = std::move(axis);
  g.value = std::move(value);
  double sizes = 0;
  int with = 0;
  for (const FamilyJudged& j : cases) {
    if (!in(j)) continue;
    add(g, j);
    if (j.set_size > 0) sizes += j.set_size, ++with;
  }
  g.set_size = with > 0 ? sizes / with : std::nan("");
  g.log_score = g.cases > 0 ? g.log_score / g.cases : std::nan("");
  return g;
}

/// The axes by which families differ, with the word of a case on each.
const std::vector<std::pair<const char*, std::function<std::string(const FamilyJudged&)>>>& axes() {
  using J = const FamilyJudged&;
  static const std::vector<std::pair<const char*, std::function<std::string(J)>>> all{
      {"vehicle", [](J j) { return j.truth->where.vehicle; }},
      {"flight", [](J j) { return j.truth->where.manoeuvre; }},
      {"level", [](J j) { return std::string(level(j)); }},
      {"kind", [](J j) { return to_string(j.truth->truth.kind); }},
      {"controller", [](J j) { return j.truth->where.controller; }},
      {"gains", [](J j) { return j.truth->where.told_gains; }},
      {"start", [](J j) { return j.truth->where.start; }},
      {"signals", [](J j) { return j.truth->where.signals; }},
      {"reference", [](J j) { return std::string(j.truth->where.reference ? "recorded" : "not recorded"); }},
      {"turbulence", [](J j) { return j.truth->where.turbulence; }},
      {"noise", [](J j) { return j.truth->where.noise; }},
      {"calibration", [](J j) { return j.truth->where.calibration; }},
      {"length",
       [](J j) {
         const double l = j.truth->where.length;
         return std::string(l < 30 ? "below 30 s" : l <= 90 ? "30 to 90 s" : "above 90 s");
       }},
      {"decoy",
       [](J j) { return j.truth->truth.decoy.empty() ? std::string("none") : j.truth->truth.decoy; }},
      {"unseen", [](J j) { return std::string(j.truth->unseen.empty() ? "no" : "yes"); }},
      {"separable",
       [](J j) {
         return std::string(!j.truth->oracle.judged     ? "not judged"
                            : j.truth->oracle.separable ? "yes"
                                                        : "no");
       }},
      {"realisation", [](J j) {
         if (j.truth->sizes.size() != 1) return std::string("several or none");
         return std::string(j.truth->sizes[0].law ? "catalogue law" : "another");
       }}};
  return all;
}

FamilyLine line(const std::vector<FamilyJudged>& cases, std::string name, std::string over, const Choice& in,
                const Choice& good, double must, double goal, bool smaller = false) {
  FamilyLine l{.name = std::move(name), .over = std::move(over)};
  for (const FamilyJudged& j : cases)
    if (in(j)) l.rate.count(good(j));
  l.value = l.rate.value();
  l.must = must;
  l.goal = goal;
  l.smaller = smaller;
  return l;
}

FamilyLine number(std::string name, std::string over, double value, int n, double must, double goal) {
  FamilyLine l{
      .name = std::move(name), .over = std::move(over), .rate = {0, n}, .is_rate = false, .value = value};
  l.must = must;
  l.goal = goal;
  l.smaller = true;
  return l;
}

Reliability reliability(const std::vector<FamilyJudged>& cases) {
  Reliability r;
  constexpr int kBins = 10;
  for (int k = 0; k < kBins; ++k) r.bins.push_back({k / double(kBins), (k + 1) / double(kBins), 0, {}});
  for (const FamilyJudged& j : cases)
    for (const Statement& s : j.statements) {
      auto& bin =
          r.bins[static_cast<std::size_t>(std::min(kBins - 1, static_cast<int>(s.probability * kBins)))];
      bin.stated += s.probability;
      bin.came_true.count(s.true_one);
      ++r.statements;
    }
  for (auto& bin : r.bins) {
    if (bin.came_true.n == 0) continue;
    bin.stated /= bin.came_true.n;
    r.expected_error += std::abs(bin.stated - bin.came_true.value()) * bin.came_true.n / r.statements;
  }
  return r;
}

/// Accuracy of first answers against the share that is answered, the surest first. Cases that no library has
/// are left out: an answer states no confidence for them.
std::vector<RiskPoint> risk_coverage(const std::vector<FamilyJudged>& cases) {
  std::vector<std::pair<double, bool>> answers;
  for (const FamilyJudged& j : cases)
    if (j.nominal || named(j)) answers.emplace_back(j.given ? j.confidence : 0, j.given && j.right());
  std::stable_sort(answers.begin(), answers.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<RiskPoint> out;
  int right = 0;
  for (std::size_t k = 0; k < answers.size(); ++k) {
    right += answers[k].second;
    if (k + 1 < answers.size() && answers[k + 1].first == answers[k].first)
      continue;  // ties are answered together
    out.push_back({static_cast<double>(k + 1) / answers.size(), static_cast<double>(right) / (k + 1),
                   answers[k].first});
  }
  return out;
}

/// Laboratories differ along it; along the others cases do.
bool is_family(const std::string& axis) {
  for (const char* other : {"all", "level", "kind", "decoy", "separable", "realisation", "effect"})
    if (axis == other) return false;
  return true;
}

void alarm_lines(FamilyScores& s) {
  const auto nominal = [](const FamilyJudged& j) { return j.nominal; };
  const auto alarm = [](const FamilyJudged& j) { return j.alarm; };
  s.lines.push_back(line(s.cases, "false alarms", "nominal flights", nominal, alarm, 0.03, 0.01, true));
  // the family in which alarms are most frequent, of those with five nominal flights or more
  double worst = -1;
  std::string where = "no family has five nominal flights";
  Rate rate;
  for (const GroupScores& g : s.groups)
    if (g.alarms.n >= 5 && is_family(g.axis) && g.alarms.value() > worst)
      worst = g.alarms.value(), where = g.axis + " = " + g.value, rate = g.alarms;
  FamilyLine l{.name = "false alarms, worst family", .over = where, .rate = rate, .value = rate.value()};
  l.must = 0.05, l.goal = 0.01, l.smaller = true;
  s.lines.push_back(l);
}

void name_lines(FamilyScores& s) {
  const auto at = [](const char* which) {
    return [which](const FamilyJudged& j) { return std::string(level(j)) == which && !j.nominal; };
  };
  const auto alarm = [](const FamilyJudged& j) { return j.alarm; };
  const auto stage = [](const FamilyJudged& j) { return j.stage; };
  const auto top1 = [](const FamilyJudged& j) { return j.top1; };
  for (const auto& [which, must, goal] : {std::tuple("1 sigma", 0.85, 0.95), {"3 sigma", 0.98, 1.0}}) {
    s.lines.push_back(
        line(s.cases, fmt::format("detection at {}", which), "all hidden", at(which), alarm, must, goal));
    s.lines.push_back(
        line(s.cases, fmt::format("stage at {}", which), "all hidden", at(which), stage, must, goal));
  }
  for (const auto& [which, must, goal, sure, best] :
       {std::tuple("1 sigma", 0.6, 0.75, 0.85, 0.92), {"3 sigma", 0.8, 0.9, 0.95, 0.99}}) {
    const auto here = at(which);
    s.lines.push_back(line(
        s.cases, fmt::format("top-1 at {}", which), "single effects, aliases merged",
        [here](const FamilyJudged& j) { return single(j) && here(j); }, top1, must, goal));
    s.lines.push_back(line(
        s.cases, fmt::format("top-1 at {}, separable", which), "those that an oracle separates",
        [here](const FamilyJudged& j) { return single(j) && here(j) && j.truth->oracle.separable; }, top1,
        sure, best));
  }
  // quadrotors beside the fully actuated, single effects of 1 sigma or more
  const auto kind = [](bool quadrotors) {
    return [quadrotors](const FamilyJudged& j) {
      const std::string& v = j.truth->where.vehicle;
      const bool quad = v.rfind("quadrotor", 0) == 0, full = v == "omnimorph" || v == "hexarotor_tilted";
      return single(j) && sigma(j) >= 0.65 && (quadrotors ? quad : full);
    };
  };
  const FamilyLine quad = line(s.cases, "", "", kind(true), top1, 0, 0),
                   full = line(s.cases, "", "", kind(false), top1, 0, 0);
  const bool both = quad.rate.n > 0 && full.rate.n > 0;
  s.lines.push_back(number("quadrotors behind the fully actuated, top-1",
                           fmt::format("{}/{} against {}/{}, single, 1 sigma or more", quad.rate.k,
                                       quad.rate.n, full.rate.k, full.rate.n),
                           both ? full.value - quad.value : std::nan(""), both ? quad.rate.n : 0, 0.10,
                           0.05));
}

void set_lines(FamilyScores& s) {
  const auto seen = [](const FamilyJudged& j) { return single(j) && j.set_size > 0 && sigma(j) >= 0.65; };
  s.lines.push_back(line(
      s.cases, "truth in the stated set", "single effects named at all, 1 sigma or more", seen,
      [](const FamilyJudged& j) { return j.covered; }, 0.92, 0.97));
  double sizes = 0;
  int n = 0;
  for (const FamilyJudged& j : s.cases)
    if (seen(j)) sizes += j.set_size, ++n;
  s.lines.push_back(number("mean size of the set", "the same", n > 0 ? sizes / n : std::nan(""), n, 2.5, 2));
  const auto of = [](Kind k) { return [k](const FamilyJudged& j) { return j.truth->truth.kind == k; }; };
  const auto exact = [](const FamilyJudged& j) { return j.exact; };
  s.lines.push_back(line(s.cases, "two effects exact", "pairs", of(Kind::pair), exact, 0.6, 0.75));
  s.lines.push_back(line(s.cases, "three effects exact", "triples", of(Kind::triple), exact, 0.4, 0.6));
  s.lines.push_back(line(
      s.cases, "out of library: unknown, stage and variable right", "1 sigma or more",
      [](const FamilyJudged& j) { return j.truth->truth.kind == Kind::unknown && sigma(j) >= 0.65; },
      [](const FamilyJudged& j) { return j.unknown_right; }, 0.85, 0.92));
  FamilyLine covers{.name = "95 % intervals cover", .over = "parameters of effects named right"};
  for (const FamilyJudged& j : s.cases) covers.rate.n += j.intervals, covers.rate.k += j.intervals_hold;
  covers.value = covers.rate.value();
  covers.must = 0.88, covers.goal = 0.92, covers.upper_must = 0.99;
  s.lines.push_back(covers);
  s.lines.push_back(number("expected calibration error", "all findings", s.reliability.expected_error,
                           s.reliability.statements, 0.08, 0.04));
  double logs = 0;
  for (const FamilyJudged& j : s.cases)
    logs += std::min(kWorstLog, -std::log(std::max(1e-9, j.true_probability)));
  FamilyLine log = number("log score (nats, 0 is best)", "all cases",
                          s.cases.empty() ? std::nan("") : logs / s.cases.size(),
                          static_cast<int>(s.cases.size()), std::nan(""), std::nan(""));
  s.lines.push_back(log);
}

}  // namespace

std::string FamilyLine::verdict() const {
  if (rate.n == 0 || std::isnan(value)) return "not judged";
  if (std::isnan(must)) return "";
  const auto meets = [&](double bound) { return smaller ? value <= bound : value >= bound; };
  if (!smaller && value > upper_must) return "SHORT";
  return meets(goal) && !(upper_must < 1 && value > 0.98) ? "goal" : meets(must) ? "must" : "SHORT";
}

FamilyScores score_families(const std::vector<FamilyCase>& truths,
                            const std::map<std::string, Answer>& answers) {
  FamilyScores s;
  for (const FamilyCase& c : truths) {
    const auto found = answers.find(c.truth.id);
    Answer none;
    none.problem = "none";
    s.cases.push_back(judge(c, found == answers.end() ? none : found->second));
  }
  s.groups.push_back(group(s.cases, "all", "", [](const FamilyJudged&) { return true; }));
  for (const auto& [axis, word] : axes()) {
    std::vector<std::string> values;
    for (const FamilyJudged& j : s.cases) values.push_back(word(j));
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    const auto& of = word;
    for (const std::string& v : values)
      s.groups.push_back(group(s.cases, axis, v, [&](const FamilyJudged& j) { return of(j) == v; }));
  }
  std::vector<std::string> effects;
  for (const FamilyCase& c : truths)
    for (const TrueEffect& e : c.truth.effects) effects.push_back(e.id);
  std::sort(effects.begin(), effects.end());
  effects.erase(std::unique(effects.begin(), effects.end()), effects.end());
  for (const std::string& id : effects)
    s.groups.push_back(group(s.cases, "effect", id, [&](const FamilyJudged& j) {
      return std::any_of(j.truth->truth.effects.begin(), j.truth->truth.effects.end(),
                         [&](const TrueEffect& e) { return e.id == id; });
    }));
  s.reliability = reliability(s.cases);
  s.risk = risk_coverage(s.cases);
  alarm_lines(s);
  name_lines(s);
  set_lines(s);
  return s;
}

}  // namespace omniflight::proof
