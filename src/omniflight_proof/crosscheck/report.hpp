// The cross-check as a page and as JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "compare_flights.hpp"
#include "hung_mass.hpp"

namespace omniflight::proof {

struct RealTimeFactor {
  std::string world;
  double factor = 0;  ///< simulated seconds per second of one processor
};
struct CrossCheck {
  std::vector<FlightDifference> flights;
  HungMass cable;
  std::vector<RealTimeFactor> speeds;

  /// Limits that the two worlds must keep; the sentence says which is broken, empty: none.
  std::vector<std::string> failures() const;
};

inline constexpr double kPositionLimit = 1e-3;    ///< m RMSE
inline constexpr double kAttitudeLimitDeg = 0.1;  ///< RMSE
inline constexpr double kPowerLimit = 0.005;      ///< relative
inline constexpr double kHungMassLimit = 0.05;    ///< relative

nlohmann::json to_json(const CrossCheck& check);
Status write_report(const CrossCheck& check, const std::filesystem::path& file);

}  // namespace omniflight::proof
