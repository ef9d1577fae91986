// Scores of a families run as JSON, text and page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "family_scores.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::proof {
namespace {

using nlohmann::json;

json number(double x) { return std::isfinite(x) ? json(x) : json(nullptr); }

json to_json(const Rate& r) {
  const Interval w = wilson(r.k, r.n);
  return {{"k", r.k}, {"n", r.n}, {"value", number(r.value())}, {"interval95", {w.low, w.high}}};
}

std::string shown(const Rate& r) { return r.n == 0 ? "-" : fmt::format("{}/{}", r.k, r.n); }
std::string percent(const Rate& r) {
  if (r.n == 0) return "-";
  const Interval w = wilson(r.k, r.n);
  return fmt::format("{:.0f} % ({}/{}, {:.0f}..{:.0f})", 100 * r.value(), r.k, r.n, 100 * w.low,
                     100 * w.high);
}
std::string value_of(const FamilyLine& l) {
  if (l.rate.n == 0 || !std::isfinite(l.value)) return "-";
  return l.is_rate ? percent(l.rate) : fmt::format("{:.3g} (n = {})", l.value, l.rate.n);
}
std::string bound(const FamilyLine& l, double b) {
  if (!std::isfinite(b)) return "";
  const std::string text = l.is_rate ? fmt::format("{:g} %", 100 * b) : fmt::format("{:g}", b);
  return (l.smaller ? "<= " : ">= ") + text;
}

/// What the proof came to, for somebody who does not know its scores.
std::string in_words(const FamilyScores& s) {
  Rate named, alarms;
  for (const FamilyLine& l : s.lines) {
    if (l.name == "top-1 at 1 sigma" || l.name == "top-1 at 3 sigma")
      named.k += l.rate.k, named.n += l.rate.n;
    if (l.name == "false alarms") alarms = l.rate;
  }
  std::string out;
  if (named.n > 0) out = fmt::format("{} of {} single hidden effects named right", named.k, named.n);
  if (alarms.n > 0)
    out += fmt::format("{}{} of {} flights with nothing hidden accused wrongly", out.empty() ? "" : ", ",
                       alarms.k, alarms.n);
  return out.empty() ? "Nothing was judged" : out;
}

}  // namespace

json to_json(const FamilyScores& s) {
  json lines = json::array(), groups = json::array(), bins = json::array(), risk = json::array(),
       cases = json::array();
  for (const FamilyLine& l : s.lines)
    lines.push_back({{"name", l.name},
                     {"over", l.over},
                     {"value", number(l.value)},
                     {"rate", l.is_rate ? to_json(l.rate) : json(nullptr)},
                     {"n", l.rate.n},
                     {"must", number(l.must)},
                     {"goal", number(l.goal)},
                     {"smaller_is_better", l.smaller},
                     {"verdict", l.verdict()}});
  for (const GroupScores& g : s.groups)
    groups.push_back({{"axis", g.axis},
                      {"value", g.value},
                      {"cases", g.cases},
                      {"false_alarms", to_json(g.alarms)},
                      {"detection", to_json(g.detected)},
                      {"stage", to_json(g.stage)},
                      {"top1", to_json(g.top1)},
                      {"in_set", to_json(g.covered)},
                      {"set_size", number(g.set_size)},
                      {"pairs_exact", to_json(g.pairs)},
                      {"triples_exact", to_json(g.triples)},
                      {"unknown", to_json(g.unknown)},
                      {"intervals", to_json(g.intervals)},
                      {"unanswered", to_json(g.unanswered)},
                      {"log_score", number(g.log_score)}});
  for (const auto& b : s.reliability.bins)
    bins.push_back(
        {{"from", b.low}, {"to", b.high}, {"stated", number(b.stated)}, {"came_true", to_json(b.came_true)}});
  for (const RiskPoint& p : s.risk)
    risk.push_back({{"answered", p.answered}, {"accuracy", p.accuracy}, {"confidence", p.confidence}});
  for (const FamilyJudged& j : s.cases) {
    const Truth& t = j.truth->truth;
    cases.push_back({{"case", t.id},
                     {"kind", to_string(t.kind)},
                     {"vehicle", j.truth->where.vehicle},
                     {"manoeuvre", j.truth->where.manoeuvre},
                     {"controller", j.truth->where.controller},
                     {"signals", j.truth->where.signals},
                     {"unseen", j.truth->unseen},
                     {"sigma", t.magnitude},
                     {"separable", j.truth->oracle.judged ? json(j.truth->oracle.separable) : json(nullptr)},
                     {"hidden", j.hidden},
                     {"said", j.said},
                     {"verdict", j.verdict},
                     {"why_wrong", j.why},
                     {"alarm", j.alarm},
                     {"right_stage", j.stage},
                     {"top1", j.top1},
                     {"in_set", j.covered},
                     {"exact", j.exact},
                     {"unknown_right", j.unknown_right},
                     {"set_size", j.set_size},
                     {"confidence", j.confidence},
                     {"probability_of_truth", j.true_probability}});
  }
  return {{"schema", "omniflight.proof_family_scores/1"},
          {"scores", lines},
          {"groups", groups},
          {"reliability",
           {{"bins", bins},
            {"expected_calibration_error", s.reliability.expected_error},
            {"statements", s.reliability.statements}}},
          {"risk_coverage", risk},
          {"cases", cases}};
}

std::string to_text(const FamilyScores& s) {
  std::string out = fmt::format("{:<50} {:>28}  {:<9} {:<9} {}\n", "score", "came out (95 % interval)",
                                "must", "goal", "verdict");
  for (const FamilyLine& l : s.lines)
    out += fmt::format("{:<50} {:>28}  {:<9} {:<9} {}\n", l.name, value_of(l), bound(l, l.must),
                       bound(l, l.goal), l.verdict());
  out += fmt::format("\n{:<12} {:<24} {:>5} {:>8} {:>9} {:>9} {:>8} {:>8} {:>5} {:>7} {:>8} {:>8} {:>7}\n",
                     "by", "", "cases", "alarms", "detected", "stage", "top-1", "in set", "size", "pairs",
                     "triples", "unknown", "log");
  for (const GroupScores& g : s.groups)
    out += fmt::format("{:<12} {:<24} {:>5} {:>8} {:>9} {:>9} {:>8} {:>8} {:>5} {:>7} {:>8} {:>8} {:>7.2f}\n",
                       g.axis, g.value, g.cases, shown(g.alarms), shown(g.detected), shown(g.stage),
                       shown(g.top1), shown(g.covered),
                       std::isfinite(g.set_size) ? fmt::format("{:.1f}", g.set_size) : "-", shown(g.pairs),
                       shown(g.triples), shown(g.unknown), g.log_score);
  out += "\nstated probability  came true\n";
  for (const auto& b : s.reliability.bins)
    if (b.came_true.n > 0) out += fmt::format("{:>8.2f}            {}\n", b.stated, percent(b.came_true));
  return out;
}

Status write_family_report(const FamilyScores& s, const std::string& headline,
                           const std::filesystem::path& file) {
  using namespace report;
  Page page("Concealed effects by family", fmt::format("{} cases. {}", s.cases.size(), headline));
  int judged = 0, met = 0;
  Table lines{{{"score"}, {"over"}, {"came out (95 % interval)"}, {"must"}, {"goal"}, {"verdict"}}, {}, ""};
  for (const FamilyLine& l : s.lines) {
    const std::string verdict = l.verdict();
    judged += verdict == "goal" || verdict == "must" || verdict == "SHORT";
    met += verdict == "goal" || verdict == "must";
    lines.rows.push_back({Cell(l.name), Cell(l.over), Cell(value_of(l)), Cell(bound(l, l.must)),
                          Cell(bound(l, l.goal)), Cell(verdict)});
  }
  page.verdict(met == judged && judged > 0 ? Tone::ok : Tone::warn, in_words(s),
               fmt::format("{} of {} musts met. {}", met, judged, headline));
  page.section("Scores").table(lines);
  page.section("By family");
  std::string axis;
  std::vector<const GroupScores*> of;
  const auto flush = [&] {
    if (of.empty()) return;
    Table t{{{"value"},
             {"cases"},
             {"false alarms"},
             {"detected"},
             {"stage"},
             {"top-1"},
             {"in set"},
             {"set size"},
             {"pairs"},
             {"triples"},
             {"unknown"},
             {"intervals"},
             {"no answer"},
             {"log score", "nats"}},
            {},
            axis};
    for (const GroupScores* g : of)
      t.rows.push_back({Cell(g->value), Cell(g->cases), Cell(percent(g->alarms)), Cell(percent(g->detected)),
                        Cell(percent(g->stage)), Cell(percent(g->top1)), Cell(percent(g->covered)),
                        Cell(g->set_size), Cell(percent(g->pairs)), Cell(percent(g->triples)),
                        Cell(percent(g->unknown)), Cell(percent(g->intervals)), Cell(shown(g->unanswered)),
                        Cell(g->log_score)});
    page.table(t);
    of.clear();
  };
  for (const GroupScores& g : s.groups) {
    if (g.axis != axis) flush();
    axis = g.axis;
    of.push_back(&g);
  }
  flush();
  Series ideal{.name = "calibrated", .x = {0, 1}, .y = {0, 1}, .dashed = true};
  Series came{.name = "came true"};
  for (const auto& b : s.reliability.bins) {
    if (b.came_true.n == 0) continue;
    const Interval w = wilson(b.came_true.k, b.came_true.n);
    came.x.push_back(b.stated);
    came.y.push_back(b.came_true.value());
    came.low.push_back(w.low);
    came.high.push_back(w.high);
  }
  page.section("Calibration");
  page.paragraph(
      fmt::format("Expected calibration error {:.3f} over {} stated probabilities. Band: Wilson 95 %.",
                  s.reliability.expected_error, s.reliability.statements));
  if (!came.x.empty())
    page.plot({.title = "Reliability of stated probabilities",
               .x_label = "stated probability",
               .y_label = "share that came true",
               .series = {ideal, came}});
  Series risk{.name = "accuracy of first answers"};
  for (const RiskPoint& p : s.risk) risk.x.push_back(p.answered), risk.y.push_back(p.accuracy);
  if (!risk.x.empty())
    page.plot({.title = "Accuracy against the share answered, the surest first",
               .x_label = "share of cases answered",
               .y_label = "accuracy",
               .series = {risk}});
  Table all{{{"case"},
             {"vehicle"},
             {"flight"},
             {"signals"},
             {"sigma"},
             {"hidden"},
             {"said"},
             {"verdict"},
             {"what is wrong"},
             {"probability of the truth"}},
            {},
            "Every case, wrong ones first"};
  std::vector<const FamilyJudged*> order;
  for (const FamilyJudged& j : s.cases) order.push_back(&j);
  std::stable_sort(order.begin(), order.end(), [](const FamilyJudged* a, const FamilyJudged* b) {
    return a->why.empty() < b->why.empty();
  });
  for (const FamilyJudged* j : order)
    all.rows.push_back({Cell(j->truth->truth.id), Cell(j->truth->where.vehicle),
                        Cell(j->truth->where.manoeuvre), Cell(j->truth->where.signals),
                        Cell(j->truth->truth.magnitude), Cell(j->hidden), Cell(j->said), Cell(j->verdict),
                        Cell(j->why), Cell(j->true_probability)});
  page.section("Cases").table(all);
  return page.write(file);
}

}  // namespace omniflight::proof
