// What many flights say: shares, errors and power with intervals, and what they depend on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "campaign_many.hpp"

namespace omniflight::cli {
namespace {

using campaign::Estimate;
using nlohmann::json;

json to_json(const Estimate& e, double scale = 1) {
  const auto number = [&](double v) { return std::isfinite(v) ? json(scale * v) : json(nullptr); };
  return {{"value", number(e.value)}, {"low", number(e.low)}, {"high", number(e.high)}};
}

/// Lost flights after all others, the earliest last.
double badness(const ManyFlight& f) { return f.lost() ? 1e6 - f.lost_at_s : f.position_rmse; }

json to_json(const Campaign& c, const campaign::ImportanceResult& r) {
  json out{{"explained_by_ranks", r.explained_by_ranks}, {"parameters", json::array()}};
  for (std::size_t k = 0; k < r.of.size(); ++k)
    out["parameters"].push_back({{"name", c.varied[k].name},
                                 {"first_order", to_json(r.of[k].first_order)},
                                 {"rank_coefficient", r.of[k].rank_coefficient}});
  return out;
}

}  // namespace

std::string words(const Estimate& e, double scale, const std::string& unit) {
  if (!std::isfinite(e.value)) return "unknown";
  const auto number = [&](double v) {
    return std::isfinite(v) ? fmt::format("{:.3g}", scale * v) : std::string(v > 0 ? "any" : "none");
  };
  return fmt::format("{} {} ({} to {})", number(e.value), unit, number(e.low), number(e.high));
}

std::vector<GroupStatistics> statistics_of(const Campaign& c, const ManyFlights& all) {
  std::vector<GroupStatistics> out;
  for (std::size_t g = 0; g < c.groups.size(); ++g) {
    GroupStatistics s;
    s.group = g;
    std::vector<double> rmse, power, bad, lost;
    std::vector<std::vector<double>> drawn(c.varied.size());
    std::size_t flown = 0;
    for (const ManyFlight& f : all.flights) {
      if (f.group != g) continue;
      ++s.flights;
      flown += f.verdict == kFlown;
      if (!f.lost()) rmse.push_back(f.position_rmse), power.push_back(f.power_W);
      bad.push_back(badness(f));
      lost.push_back(f.lost() ? 1.0 : 0.0);
      for (std::size_t k = 0; k < drawn.size(); ++k) drawn[k].push_back(f.drawn[k]);
    }
    s.flown = campaign::share(flown, s.flights);
    s.survived = campaign::share(rmse.size(), s.flights);
    s.lost = campaign::share(s.flights - rmse.size(), s.flights);
    s.mean_rmse = campaign::mean(rmse);
    s.median_rmse = campaign::quantile(rmse, 0.5);
    s.rmse_95 = campaign::quantile(rmse, 0.95);
    s.rmse_99 = campaign::quantile(rmse, 0.99);
    s.mean_power = campaign::mean(power);
    s.error = campaign::importance(drawn, bad);
    s.loss = campaign::importance(drawn, lost);
    out.push_back(std::move(s));
  }
  return out;
}

json to_json(const Campaign& c, const ManyFlights& all, const std::vector<GroupStatistics>& statistics,
             const std::vector<Judgement>& judgements, const jobs::ExecutorOptions& executor) {
  json j{{"schema", "omniflight.campaign_result/1"},
         {"name", c.name},
         {"in_process", true},
         {"planned", c.groups.size() * c.seeds.size()},
         {"kept", all.kept},
         {"verdict", verdict_in_words(judgements)},
         {"simulated_s", all.simulated_s},
         {"flights_per_core_second", all.cpu_s > 0 ? static_cast<double>(all.flights.size()) / all.cpu_s : 0},
         {"seconds",
          {{"plan", all.plan_s},
           {"submit", all.ran.submit_s},
           {"work", all.ran.work_s},
           {"collect", all.ran.collect_s},
           {"processor", all.cpu_s}}},
         {"executor", to_json(all.ran, executor)},
         {"missing", all.missing},
         {"groups", json::array()},
         {"varied", json::array()},
         {"expectations", to_json(judgements)},
         {"flights", json::array()}};
  for (const campaign::Varied& v : c.varied) j["varied"].push_back({{"name", v.name}, {"unit", v.unit}});
  for (const GroupStatistics& s : statistics)
    j["groups"].push_back({{"name", c.groups[s.group].name},
                           {"flights", s.flights},
                           {"flown", to_json(s.flown)},
                           {"survived", to_json(s.survived)},
                           {"lost", to_json(s.lost)},
                           {"position_rmse_mean_m", to_json(s.mean_rmse)},
                           {"position_rmse_median_m", to_json(s.median_rmse)},
                           {"position_rmse_95_m", to_json(s.rmse_95)},
                           {"position_rmse_99_m", to_json(s.rmse_99)},
                           {"power_mean_W", to_json(s.mean_power)},
                           {"importance_for_error", to_json(c, s.error)},
                           {"importance_for_loss", to_json(c, s.loss)}});
  for (const ManyFlight& f : all.flights)
    j["flights"].push_back({{"name", fmt::format("{}-seed{}", c.groups[f.group].name, f.seed)},
                            {"verdict", f.verdict},
                            {"drawn", f.drawn},
                            {"position_rmse_m", f.position_rmse},
                            {"worst_position_m", f.worst_position},
                            {"attitude_rmse_deg", f.attitude_rmse_deg},
                            {"power_W", f.power_W},
                            {"least_headroom", f.least_headroom},
                            {"lost_at_s", f.lost_at_s > 0 ? json(f.lost_at_s) : json(nullptr)}});
  return j;
}

}  // namespace omniflight::cli
