// The page of a campaign: the answer, who did best, and the flights side by side.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "campaign.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {
namespace {

constexpr std::size_t kMostPlotted = 48, kMostLines = 8;
constexpr double kDrawnAt = 2.0;  // m: a lost flight would flatten the others

std::string in_a_cell(const Outcome& o) {
  if (const double at = figure(o.json, "/left_reference_at_s"); !o.survived())
    return std::isfinite(at) ? fmt::format("lost at {:.1f} s", at) : o.verdict;
  return fmt::format("{:.1f} mm{}", 1e3 * position_rmse(o.json), o.flown() ? "" : " (badly)");
}

/// Worst first: lost flights, the earliest before the others, then by position error.
std::vector<const Outcome*> ranked(const std::vector<Outcome>& outcomes) {
  std::vector<const Outcome*> out;
  for (const Outcome& o : outcomes) out.push_back(&o);
  const auto badness = [](const Outcome& o) {
    if (o.survived()) return position_rmse(o.json);
    const double at = figure(o.json, "/left_reference_at_s");
    return 1e9 - (std::isfinite(at) ? at : 0.0);
  };
  std::stable_sort(out.begin(), out.end(),
                   [&](const Outcome* a, const Outcome* b) { return badness(*a) > badness(*b); });
  return out;
}

std::string label(const Outcome& o, bool many_missions) {
  return (many_missions ? o.flight.mission + ", " : "") + o.flight.effect + ", " + o.flight.variant +
         ", seed " + std::to_string(o.flight.options.seed);
}

/// "12 of 10000", or that nobody counted.
std::string missed_periods(const nlohmann::json& flight) {
  if (!flight.contains("periods_missed") || !flight.contains("periods")) return "not counted";
  return flight["periods_missed"].dump() + " of " + flight["periods"].dump();
}

report::Table ranking(const std::vector<const Outcome*>& rows) {
  report::Table t;
  t.caption = "Ranked, worst first: lost flights, then by position error (true state where it is known)";
  t.columns = {{.name = "mission"},
               {.name = "effect"},
               {.name = "variant"},
               {.name = "seed"},
               {.name = "verdict"},
               {.name = "RMSE", .unit = "mm", .significant_digits = 3},
               {.name = "largest", .unit = "mm", .significant_digits = 3},
               {.name = "power", .unit = "W"},
               {.name = "integral z", .unit = "m/s2", .significant_digits = 3}};
  const bool boards = std::any_of(rows.begin(), rows.end(), [](const Outcome* o) {
    return o->json.contains("periods_missed");  // only a plant in real time misses any
  });
  if (boards) {
    t.columns.push_back({.name = "missed periods"});
    t.columns.push_back({.name = "latest", .unit = "ms", .significant_digits = 3});
  }
  for (const Outcome* o : rows) {
    t.rows.push_back({o->flight.mission, o->flight.effect, o->flight.variant,
                      std::to_string(o->flight.options.seed), o->flown() ? "flown" : in_a_cell(*o),
                      1e3 * position_rmse(o->json), 1e3 * figure(o->json, "/worst_position_m"),
                      figure(o->json, "/power_W"), figure(o->json, "/mean_integral_action/2")});
    if (!boards) continue;
    t.rows.back().emplace_back(missed_periods(o->json));
    t.rows.back().emplace_back(o->json.value("period_latest_ms", std::nan("")));
  }
  return t;
}

/// Rows: mission and effect; columns: variants; cells: what each seed gave.
report::Table side_by_side(const std::vector<Outcome>& outcomes) {
  std::vector<std::string> variants, places;
  std::map<std::pair<std::string, std::string>, std::string> cells;
  const auto remember = [](std::vector<std::string>& list, const std::string& item) {
    if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
  };
  for (const Outcome& o : outcomes) {
    const std::string place = o.flight.mission + ", " + o.flight.effect;
    remember(variants, o.flight.variant);
    remember(places, place);
    std::string& cell = cells[{place, o.flight.variant}];
    cell += (cell.empty() ? "" : ", ") + in_a_cell(o);
  }
  report::Table t;
  t.caption = "Position RMSE of each seed, or when the flight was lost";
  t.columns = {{.name = "mission, effect"}};
  for (const std::string& v : variants) t.columns.push_back({.name = v});
  for (const std::string& place : places) {
    t.rows.push_back({report::Cell(place)});
    for (const std::string& v : variants) t.rows.back().push_back(report::Cell(cells[{place, v}]));
  }
  return t;
}

struct Curves {
  report::TimePlot error, tilt, power;
};

void add_curves(Curves& plots, const Outcome& o, const std::string& folder) {
  if (plots.error.series.size() >= kMostLines) return;
  const auto r = recording::load(folder + "/" + o.flight.name + "/flight.mcap", {});
  if (!r) return;
  const std::string name = o.flight.variant + ", seed " + std::to_string(o.flight.options.seed);
  const auto* position = r->find("truth_position") ? r->find("truth_position") : r->find("position");
  const auto* reference = r->find("ref_position");
  if (position && reference) {
    const Eigen::MatrixXd wanted = recording::resample(*reference, position->t_s);
    report::Series s{.name = name};
    for (Eigen::Index i = 0; i < position->size(); ++i) {
      if (!wanted.row(i).allFinite()) continue;  // before the first reference
      s.x.push_back(position->t_s[static_cast<std::size_t>(i)]);
      s.y.push_back(std::min((position->values.row(i) - wanted.row(i)).norm(), kDrawnAt));
    }
    plots.error.series.push_back(std::move(s));
  }
  if (const auto* alpha = r->find("alpha_command")) {
    report::Series s{.name = name, .x = alpha->t_s};
    for (Eigen::Index i = 0; i < alpha->size(); ++i) s.y.push_back(to_degrees(alpha->values(i, 0)));
    plots.tilt.series.push_back(std::move(s));
  }
  if (const auto* power = r->find("truth_power")) {
    report::Series s{.name = name, .x = power->t_s};
    for (Eigen::Index i = 0; i < power->size(); ++i) s.y.push_back(power->values(i, 0));
    plots.power.series.push_back(std::move(s));
  }
}

void plot_flights(report::Page& page, const std::vector<Outcome>& outcomes, const std::string& out) {
  std::vector<std::string> order;
  std::map<std::string, Curves> by_place;
  std::size_t plotted = 0;
  for (const Outcome& o : outcomes) {
    if (plotted++ >= kMostPlotted) break;
    const std::string place = o.flight.mission + ", " + o.flight.effect;
    const auto [at, fresh] = by_place.try_emplace(place);
    if (fresh) order.push_back(place);
    add_curves(at->second, o, out);
  }
  page.section("Over time");
  for (const std::string& place : order) {
    Curves& c = by_place[place];
    if (c.error.series.empty()) continue;
    c.error.title = "Position error (2 m and more drawn at 2 m): " + place;
    c.error.y_label = "error [m]";
    c.tilt.title = "Commanded tilt: " + place;
    c.tilt.y_label = "tilt [deg]";
    c.power.title = "Mechanical power: " + place;
    c.power.y_label = "power [W]";
    for (report::TimePlot* p : {&c.error, &c.tilt, &c.power}) {
      p->group = place;
      p->height_px = 200;
      if (!p->series.empty()) page.plot(std::move(*p));
    }
  }
  if (outcomes.size() > kMostPlotted)
    page.paragraph(
        fmt::format("The first {} flights are plotted, at most {} a plot.", kMostPlotted, kMostLines));
}

/// Of a campaign that looks for causes: in how many cases one was found, which, and after how many flights.
void cause_verdict(report::Page& page, const std::vector<Outcome>& outcomes) {
  std::size_t asked = 0, found = 0, most = 0;
  std::string lines, cause;
  for (const Outcome& o : outcomes) {
    if (o.investigation.empty()) continue;
    ++asked;
    lines += (lines.empty() ? "" : "\n") + o.flight.name + ": " + o.investigation + ".";
    if (o.cause.empty()) continue;
    ++found;
    cause = o.cause;
    most = std::max(most, o.flights);
  }
  const std::string flights = fmt::format("{} flight{}", most, most == 1 ? "" : "s");
  std::string headline =
      fmt::format("One cause left in {} of {} cases, after {} at most", found, asked, flights);
  if (asked == 1) headline = fmt::format("Cause found after {}: {}", flights, cause);
  if (found == 0) headline = "No case is down to one cause";
  page.verdict(found == asked ? report::Tone::ok : report::Tone::warn, headline, lines);
}

void flown_verdict(report::Page& page, const std::string& counted, bool all,
                   const std::vector<const Outcome*>& rows) {
  std::string best;
  if (!rows.empty() && rows.back()->survived())
    best = fmt::format("Best: {} ({}). Worst: {} ({}).", label(*rows.back(), true), in_a_cell(*rows.back()),
                       label(*rows.front(), true), in_a_cell(*rows.front()));
  page.verdict(all ? report::Tone::ok : report::Tone::warn, counted, best);
}

void expected_verdict(report::Page& page, const std::string& counted,
                      const std::vector<Judgement>& judgements, std::size_t not_flown) {
  const bool all =
      std::all_of(judgements.begin(), judgements.end(), [](const Judgement& j) { return j.met(); });
  page.verdict(!all             ? report::Tone::bad
               : not_flown == 0 ? report::Tone::ok
                                : report::Tone::warn,
               headline(judgements, not_flown),
               fmt::format("{}; {} expectations.", counted, judgements.size()));
  report::Table t;
  t.columns = {{.name = "expectation, and what came"}};
  for (const Judgement& j : judgements) t.rows.push_back({report::Cell(j.words())});
  page.table(t);
}

void bars_of(report::Page& page, const std::vector<const Outcome*>& rows) {
  report::Bars error{.title = "Position RMSE of flights flown to the end", .unit = "mm"},
      power{.title = "Mean power of flights flown to the end", .unit = "W"};
  std::set<std::string> missions;
  for (const Outcome* o : rows) missions.insert(o->flight.mission);
  for (const Outcome* o : rows) {
    if (!o->survived() || error.bars.size() >= 60) continue;
    const std::string name = label(*o, missions.size() > 1);
    error.bars.push_back({.name = name, .value = 1e3 * position_rmse(o->json)});
    if (const double p = figure(o->json, "/power_W"); std::isfinite(p))
      power.bars.push_back({.name = name, .value = p});
  }
  if (!error.bars.empty()) page.bars(error);
  if (!power.bars.empty()) page.bars(power);
}

}  // namespace

Status write_campaign_page(const Campaign& c, const std::vector<Outcome>& outcomes,
                           const std::vector<Judgement>& judgements, const std::string& out) {
  std::vector<std::string> verdicts;
  for (const Outcome& o : outcomes)
    if (!o.verdict.empty()) verdicts.push_back(o.verdict);
  const std::string counted = flown_in_words(verdicts, c.cases.size());
  const bool all_flown = std::all_of(outcomes.begin(), outcomes.end(), [](auto& o) { return o.flown(); }) &&
                         outcomes.size() == c.cases.size();
  report::Page page("Campaign " + c.name, c.question.empty() ? counted : c.question);
  const auto rows = ranked(outcomes);
  if (std::any_of(outcomes.begin(), outcomes.end(), [](auto& o) { return !o.investigation.empty(); }))
    cause_verdict(page, outcomes);
  if (c.expected.empty())
    flown_verdict(page, counted, all_flown, rows);
  else
    expected_verdict(page, counted, judgements, c.cases.size() - verdicts.size());
  page.section("Side by side").table(side_by_side(outcomes));
  page.section("Ranking").table(ranking(rows));
  bars_of(page, rows);
  plot_flights(page, outcomes, out);
  return page.write(out + "/report.html");
}

}  // namespace omniflight::cli
