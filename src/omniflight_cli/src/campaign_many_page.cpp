// The page of a campaign without a bus: shares, errors, what they depend on, and the flights as points.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "campaign_many.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {
namespace {

constexpr const char* kIntervals =
    "In brackets: 95 % confidence. Shares by Wilson's score interval, means by Student's t, quantiles "
    "between "
    "order statistics (no distribution is assumed). Errors and power are of flights that were not lost.";
constexpr const char* kImportance =
    "First-order index: the share of the variance of the ranked position error that would go if this "
    "parameter "
    "alone were known (equal-frequency bins, Plischke et al. 2013, less what bins explain by chance; "
    "whiskers: "
    "95 % bootstrap). Lost flights rank last. What parameters do only together is in none of the indices: it "
    "is what lacks to 1. Rank coefficient: -1 to 1, the direction (Iman and Conover 1979).";

report::Table shares(const Campaign& c, const std::vector<GroupStatistics>& all) {
  report::Table t;
  t.caption = kIntervals;
  t.columns = {{.name = "mission, effect, variant"},
               {.name = "flights"},
               {.name = "flown"},
               {.name = "flown or badly"},
               {.name = "lost"},
               {.name = "RMSE, mean"},
               {.name = "RMSE, median"},
               {.name = "95 % below"},
               {.name = "99 % below"},
               {.name = "power, mean"}};
  for (const GroupStatistics& s : all) {
    const Case& g = c.groups[s.group];
    t.rows.push_back({g.mission + ", " + g.effect + ", " + g.variant, static_cast<double>(s.flights),
                      words(s.flown, 100, "%"), words(s.survived, 100, "%"), words(s.lost, 100, "%"),
                      words(s.mean_rmse, 1e3, "mm"), words(s.median_rmse, 1e3, "mm"),
                      words(s.rmse_95, 1e3, "mm"), words(s.rmse_99, 1e3, "mm"), words(s.mean_power, 1, "W")});
  }
  return t;
}

void importance(report::Page& page, const Campaign& c, const campaign::ImportanceResult& r,
                const std::string& of) {
  if (r.of.empty()) return;
  report::Bars bars{.title = "First-order index for " + of, .full = 1.0};
  report::Table t;
  t.columns = {{.name = "parameter"},
               {.name = "first-order index", .significant_digits = 3},
               {.name = "from", .significant_digits = 3},
               {.name = "to", .significant_digits = 3},
               {.name = "rank coefficient", .significant_digits = 3}};
  double sum = 0;
  for (std::size_t k = 0; k < r.of.size(); ++k) {
    const auto& i = r.of[k];
    sum += i.first_order.value;
    bars.bars.push_back({.name = c.varied[k].name,
                         .value = std::max(0.0, i.first_order.value),
                         .low = std::max(0.0, i.first_order.low),
                         .high = std::max(0.0, i.first_order.high)});
    t.rows.push_back(
        {c.varied[k].name, i.first_order.value, i.first_order.low, i.first_order.high, i.rank_coefficient});
  }
  page.bars(bars).table(t).paragraph(fmt::format(
      "Sum of the indices {:.2f}; the rank regression explains {:.0f} % of the variance of the ranks.", sum,
      100 * r.explained_by_ranks));
}

/// Position error over each varied parameter, and its distribution function.
void points(report::Page& page, const Campaign& c, const ManyFlights& all, std::size_t group) {
  for (std::size_t k = 0; k < c.varied.size(); ++k) {
    report::TimePlot plot{
        .title = "Position RMSE over " + c.varied[k].name,
        .x_label = c.varied[k].name + (c.varied[k].unit.empty() ? "" : " [" + c.varied[k].unit + "]"),
        .y_label = "position RMSE [mm]"};
    report::Series s{.name = "a flight", .points = true};
    for (const ManyFlight& f : all.flights)
      if (f.group == group && !f.lost()) {
        s.x.push_back(f.drawn[k]);
        s.y.push_back(1e3 * f.position_rmse);
      }
    if (s.x.empty()) continue;
    plot.series.push_back(std::move(s));
    page.plot(std::move(plot));
  }
  std::vector<double> rmse;
  std::size_t flights = 0;
  for (const ManyFlight& f : all.flights) {
    if (f.group != group) continue;
    ++flights;
    if (!f.lost()) rmse.push_back(1e3 * f.position_rmse);
  }
  if (rmse.empty()) return;
  std::sort(rmse.begin(), rmse.end());
  report::TimePlot plot{.title = "Share of all flights with a position RMSE of at most ...",
                        .x_label = "position RMSE [mm]",
                        .y_label = "share [1]"};
  report::Series s{.name = "share"};
  for (std::size_t k = 0; k < rmse.size(); ++k) {
    s.x.push_back(rmse[k]);
    s.y.push_back(static_cast<double>(k + 1) / static_cast<double>(flights));
  }
  plot.series.push_back(std::move(s));
  page.plot(std::move(plot));
}

}  // namespace

Status write_many_page(const Campaign& c, const ManyFlights& all,
                       const std::vector<GroupStatistics>& statistics,
                       const std::vector<Judgement>& judgements, const std::string& out) {
  const std::size_t planned = c.groups.size() * c.seeds.size();
  std::vector<std::string> verdicts;
  for (const ManyFlight& f : all.flights) verdicts.push_back(f.verdict);
  const std::string counted = flown_in_words(verdicts, planned);
  report::Page page("Campaign " + c.name, c.question.empty() ? counted : c.question);
  const bool whole = all.flights.size() == planned;
  if (c.expected.empty()) {
    const bool all_flown = whole && std::all_of(all.flights.begin(), all.flights.end(),
                                                [](auto& f) { return f.verdict == kFlown; });
    page.verdict(
        all_flown ? report::Tone::ok : report::Tone::warn, counted,
        "Flights of plant, control law and allocation on the true state: no sensors, estimator, failsafe "
        "or bus.");
  } else {
    const bool met = std::all_of(judgements.begin(), judgements.end(), [](auto& e) { return e.met(); });
    page.verdict(met && whole ? report::Tone::ok : report::Tone::bad,
                 headline(judgements, planned - all.flights.size()), counted + ".");
    report::Table t;
    t.columns = {{.name = "expectation, and what came"}};
    for (const Judgement& e : judgements) t.rows.push_back({report::Cell(e.words())});
    page.table(t);
  }
  page.section("Shares and errors").table(shares(c, statistics));
  for (const GroupStatistics& s : statistics) {
    const Case& g = c.groups[s.group];
    page.section(g.mission + ", " + g.effect + ", " + g.variant);
    if (!s.error.of.empty()) page.paragraph(kImportance);
    importance(page, c, s.error, "the position error");
    importance(page, c, s.loss, "being lost");
    points(page, c, all, s.group);
  }
  if (!all.missing.empty()) {
    report::Table t;
    t.columns = {{.name = "jobs without a result, and why"}};
    for (const std::string& m : all.missing) t.rows.push_back({report::Cell(m)});
    page.section("Missing").table(t);
  }
  return page.write(out + "/report.html");
}

}  // namespace omniflight::cli
