// Two recordings of one mission, flown in two worlds.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

struct FlightDifference {
  std::string mission;
  double position_rmse = 0;          ///< m, distance between the true positions
  double position_max = 0;           ///< m
  double attitude_rmse_deg = 0;      ///< angle between the true attitudes
  double power[2] = {0, 0};          ///< W, mean of rotor torque times speed by telemetry
  double duration = 0;               ///< s of free flight that were compared
  double tracking_rmse[2] = {0, 0};  ///< m, each against its reference
  std::vector<double> t, distance_mm, angle_mdeg;

  double power_ratio() const { return power[1] / power[0]; }
};

/// From the release on (phase 1). Fails when a recording has no true state, or they share less than a second.
Result<FlightDifference> compare_flights(const std::filesystem::path& first,
                                         const std::filesystem::path& second,
                                         const vehicle::Vehicle& vehicle);

}  // namespace omniflight::proof
