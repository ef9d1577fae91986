#include "prove_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "omniflight_report/page.hpp"

namespace omniflight::proof {
namespace {

using nlohmann::json;

json number_or_null(double x) { return std::isfinite(x) ? json(x) : json(nullptr); }

json to_json(const Score& s) {
  json j = {{"name", s.name},
            {"over", s.over},
            {"n", s.n},
            {"value", number_or_null(s.value)},
            {"verdict", to_string(s.verdict)}};
  if (s.is_rate) {
    j["k"] = s.k;
    j["interval95"] = {s.interval.low, s.interval.high};
  } else {
    j["unit"] = s.unit;
  }
  if (!s.must.empty()) j["must"] = s.must, j["goal"] = s.goal;
  return j;
}

json to_json(const LeakResult& l) {
  return {
      {"accuracy", l.accuracy}, {"chance", l.chance}, {"p_value", l.p_value}, {"most_telling", l.feature}};
}

json to_json(const std::map<std::string, Scores>& others) {
  json out = json::object();
  for (const auto& [name, scores] : others) {
    json t = json::array();
    for (const auto& s : scores.table) t.push_back(to_json(s));
    out[name] = {{"scores", t}, {"confusion", scores.confusion}, {"cases", scores.cases.size()}};
  }
  return out;
}

std::string shown(const Score& s) {
  if (s.n == 0) return "-";
  if (!s.is_rate) return fmt::format("{:.3g} {}", s.value, s.unit);
  return fmt::format("{:.1f} % ({} of {})", 100 * s.value, s.k, s.n);
}

const Score* find(const Scores& scores, const std::string& name) {
  for (const auto& s : scores.table)
    if (s.name == name) return &s;
  return nullptr;
}

/// The lines that comparing makes sense for.
constexpr const char* kCompared[] = {"false alarms",
                                     "detection at >= 0.3 sigma",
                                     "right stage",
                                     "right effect, top-1",
                                     "truth inside the stated set",
                                     "two effects exact",
                                     "three effects exact",
                                     "out of library: unknown, stage and variable right",
                                     "parameter error, median",
                                     "95 % interval covers"};

report::Table side_by_side(const std::string& name, const Scores& own,
                           const std::map<std::string, Scores>& others, const std::string& title) {
  using namespace report;
  Table t{{{"score"}, {"must"}, {.name = name, .align = Align::right}}, {}, title};
  for (const auto& [other, ignored] : others) t.columns.push_back({.name = other, .align = Align::right});
  for (const char* line : kCompared) {
    const Score* first = find(own, line);
    if (!first) continue;
    std::vector<Cell> row{Cell(line), Cell(first->must), Cell(shown(*first))};
    for (const auto& [other, scores] : others) {
      const Score* s = find(scores, line);
      row.emplace_back(s ? shown(*s) : std::string("-"));
    }
    t.rows.push_back(row);
  }
  return t;
}

/// "31 of 40" of a line of the table, empty where nothing was judged by it.
std::string out_of(const Scores& scores, const std::string& name) {
  const Score* s = find(scores, name);
  return s && s->n > 0 ? fmt::format("{} of {}", s->k, s->n) : "";
}

/// What the proof came to, for somebody who does not know its scores.
std::string in_words(const Scores& scores, bool sealed) {
  std::string out;
  const auto add = [&](const std::string& counted, const char* what) {
    if (!counted.empty()) out += (out.empty() ? "" : ", ") + counted + what;
  };
  add(out_of(scores, "right effect, top-1"), " hidden effects named right");
  add(out_of(scores, "detection at >= 0.3 sigma"), " flights with something hidden noticed");
  add(out_of(scores, "false alarms"), " flights with nothing hidden accused wrongly");
  if (out.empty()) out = "Nothing was judged";
  return sealed ? out : "Not sealed, so that this proves nothing: " + out;
}

}  // namespace

json to_json(const ProofResult& r) {
  json table = json::array(), cases = json::array();
  for (const auto& s : r.scores.table) table.push_back(to_json(s));
  for (const Judged& j : r.scores.cases)
    cases.push_back({{"case", j.id},
                     {"kind", j.kind},
                     {"level", j.level},
                     {"flight", j.flight},
                     {"magnitude_sigma", j.magnitude},
                     {"truth", j.truth},
                     {"said", j.said},
                     {"hidden", j.hidden},
                     {"named", j.named},
                     {"verdict", j.verdict},
                     {"why_wrong", j.why},
                     {"alarm", j.alarm},
                     {"detected", j.detected},
                     {"right_stage", j.stage},
                     {"top1", j.top1},
                     {"in_set", j.covered},
                     {"exact", j.exact},
                     {"set_size", j.set_size},
                     {"held_out_explained", number_or_null(j.explained)}});
  return {{"schema", "omniflight.proof/1"},
          {"sealed", r.probe.value("sealed", false)},
          {"confinement", r.probe},
          {"commitment", r.commitment},
          {"truth_sha256", r.truth_sha256},
          {"answers_sha256", r.answers_sha256},
          {"answers_next_sha256", r.answers_next_sha256},
          {"ablations_sha256", r.ablations_sha256},
          {"salt", r.salt},
          {"box", r.box},
          {"scores", table},
          {"baselines", to_json(r.baselines)},
          {"ablations", to_json(r.ablations)},
          {"confusion", r.scores.confusion},
          {"leak_test",
           {{"must", fmt::format("p >= {}", kLeakMust)},
            {"which_effect", to_json(r.leak)},
            {"whether_any", to_json(r.leak_whether)}}},
          {"runtime",
           {{"median_s", number_or_null(r.median_s)}, {"longest_s", r.longest_s}, {"sum_s", r.analysis_s}}},
          {"cases", cases}};
}

Status write_report(const ProofResult& r, const std::filesystem::path& file) {
  using namespace report;
  int judged = 0, goal = 0, must = 0;
  std::string missed;
  for (const auto& s : r.scores.table) {
    if (s.must.empty() || s.verdict == Score::Verdict::not_judged) continue;
    ++judged;
    goal += s.verdict == Score::Verdict::goal;
    must += s.verdict == Score::Verdict::must || s.verdict == Score::Verdict::goal;
    if (s.verdict == Score::Verdict::short_of) missed += (missed.empty() ? "" : "; ") + s.name;
  }
  const bool sealed = r.probe.value("sealed", false);
  Page page("Concealed effects",
            fmt::format("{} cases, judged after the answers were frozen", r.scores.cases.size()));
  page.verdict(must == judged && judged > 0 && sealed ? Tone::ok : Tone::warn, in_words(r.scores, sealed),
               fmt::format("{} of {} musts met, {} of {} goals. ", must, judged, goal, judged) +
                   (sealed ? std::string("The analysis could not read the truth. ")
                           : std::string("NOT SEALED: the analysis could have read the truth. ")) +
                   (missed.empty() ? "" : "Short of the must: " + missed + "."));
  Table scores{
      {{"score"}, {"over"}, {"came out"}, {"95 % interval"}, {"must"}, {"goal"}, {"verdict"}}, {}, ""};
  for (const auto& s : r.scores.table)
    scores.rows.push_back({Cell(s.name), Cell(s.over), Cell(shown(s)),
                           Cell(s.is_rate && s.n > 0 ? fmt::format("{:.1f} to {:.1f} %", 100 * s.interval.low,
                                                                   100 * s.interval.high)
                                                     : std::string("-")),
                           Cell(s.must), Cell(s.goal), Cell(to_string(s.verdict))});
  page.section("Scores").table(scores);
  if (!r.baselines.empty())
    page.section("Against textbook methods")
        .table(side_by_side("omniflight", r.scores, r.baselines,
                            "The same sealed cases, judged by the same program"));
  if (const auto whole = r.ablations.find(kWhole); whole != r.ablations.end()) {
    auto others = r.ablations;
    others.erase(kWhole);
    page.section("Without a safeguard, or with something wrong that was not told")
        .table(side_by_side(kWhole, whole->second, others,
                            fmt::format("Ablations, {} cases", whole->second.cases.size())));
  }
  Matrix m{.title = "First answer by hidden effect (single effects, unknown ones, nominal flights)",
           .value_label = "cases",
           .row_title = "hidden",
           .column_title = "said"};
  for (const auto& [truth, row] : r.scores.confusion) {
    m.rows.push_back(truth);
    for (const auto& [said, n] : row)
      if (std::find(m.columns.begin(), m.columns.end(), said) == m.columns.end()) m.columns.push_back(said);
  }
  std::sort(m.columns.begin(), m.columns.end());
  for (const auto& [truth, row] : r.scores.confusion) {
    m.values.emplace_back();
    for (const auto& said : m.columns) m.values.back().push_back(row.count(said) ? row.at(said) : 0);
  }
  page.section("Confusion").matrix(m);
  Page& leaks = page.section("Leak test");
  for (const auto& [what, leak] :
       {std::pair("which effect is hidden", r.leak), {"whether any is", r.leak_whether}})
    leaks.paragraph(
        fmt::format("Guessing {} from names, sizes, times and order of the files and from what is told "
                    "beside them: {:.1f} % "
                    "right, chance {:.1f} %, p = {:.2f} (most telling: {}). {}",
                    what, 100 * leak.accuracy, 100 * leak.chance, leak.p_value, leak.feature,
                    leak.p_value < kLeakMust ? "It leaks: what follows proves nothing." : ""));
  std::vector<Judged> cases = r.scores.cases;
  std::stable_sort(cases.begin(), cases.end(),
                   [](const Judged& a, const Judged& b) { return a.badness > b.badness; });
  Table all{{{"case"},
             {"kind"},
             {"level"},
             {"flight"},
             {"sigma"},
             {"hidden"},
             {"said"},
             {"verdict"},
             {"what is wrong"},
             {"held out explained", "%"}},
            {},
            ""};
  for (const Judged& j : cases)
    all.rows.push_back({Cell(j.id), Cell(j.kind), Cell(j.level), Cell(j.flight), Cell(j.magnitude),
                        Cell(j.hidden), Cell(j.named), Cell(j.verdict), Cell(j.why),
                        Cell(100 * j.explained)});
  page.section("Cases").details(fmt::format("{} cases, the worst first", all.rows.size()),
                                [&](Page& p) { p.table(all); });
  page.section("Seal and times");
  page.facts({{"truth, SHA-256", r.truth_sha256},
              {"answers, SHA-256", r.answers_sha256},
              {"confinement", r.probe.value("confinement", "?")},
              {"parameter boxes", r.box},
              {"median diagnosis", fmt::format("{:.1f}", r.median_s), "s"},
              {"longest diagnosis", fmt::format("{:.1f}", r.longest_s), "s"}});
  return page.write(file);
}

}  // namespace omniflight::proof
