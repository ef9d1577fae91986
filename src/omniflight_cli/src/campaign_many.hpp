// Flights of a campaign without a bus: their parts, and what came of each flight.
#pragma once

#include "campaign_run.hpp"
#include "omniflight_campaign/importance.hpp"
#include "omniflight_campaign/many_flights.hpp"
#include "omniflight_campaign/statistics.hpp"

namespace omniflight::cli {

/// Some flights of a group: one job.
struct Part {
  std::size_t group = 0, first = 0, count = 0;  ///< `first` counts in Campaign::seeds
  std::string name(const Campaign& campaign) const;
  std::string spec() const;  ///< of --part
};
Result<Part> part_from(const std::string& spec, const Campaign& campaign);

/// One flight, as its part tells it.
struct ManyFlight {
  std::size_t group = 0;
  std::uint64_t seed = 0;
  std::vector<double> drawn;  ///< a value a varied parameter, in its unit
  std::string verdict;
  double position_rmse = 0, worst_position = 0;  ///< m
  double attitude_rmse_deg = 0, power_W = 0, least_headroom = 0;
  double lost_at_s = 0;  ///< when it was too far from its reference; 0: it was followed to the end
  bool lost() const { return verdict == kLost; }
};

/// What a part cost and what is in it.
struct PartResult {
  std::string inputs;      ///< hash of everything that decides it
  double cpu_s = 0;        ///< of the whole process that flew it
  double simulated_s = 0;  ///< of one flight
  std::vector<ManyFlight> flights;
};
std::string to_text(const PartResult& part);
/// Refuses a file that is damaged, naming the field.
Result<PartResult> read_part(const std::string& file);

/// All parts together.
struct ManyFlights {
  std::vector<ManyFlight> flights;
  std::size_t kept = 0;  ///< flights of parts that were there
  double cpu_s = 0, simulated_s = 0, plan_s = 0;
  std::vector<std::string> missing;  ///< parts without a result, and why
  jobs::Ran ran;
};

/// Statistics of one group.
struct GroupStatistics {
  std::size_t group = 0, flights = 0;
  campaign::Estimate flown, survived, lost;                     ///< shares
  campaign::Estimate mean_rmse, median_rmse, rmse_95, rmse_99;  ///< m, of flights that survived
  campaign::Estimate mean_power;                                ///< W, likewise
  campaign::ImportanceResult error, loss;  ///< of the position error (lost flights last); of being lost
};
std::vector<GroupStatistics> statistics_of(const Campaign& campaign, const ManyFlights& all);

nlohmann::json to_json(const Campaign& campaign, const ManyFlights& all,
                       const std::vector<GroupStatistics>& statistics,
                       const std::vector<Judgement>& judgements, const jobs::ExecutorOptions& executor);
Status write_many_page(const Campaign& campaign, const ManyFlights& all,
                       const std::vector<GroupStatistics>& statistics,
                       const std::vector<Judgement>& judgements, const std::string& out);
/// "20 mm (18 to 23)": value and interval, times `scale`.
std::string words(const campaign::Estimate& e, double scale, const std::string& unit);

}  // namespace omniflight::cli
