// Whether a flight was what its plan says: reached, tracked, clear of the map, with rotors to spare.
#pragma once

#include <nlohmann/json.hpp>

#include "metrics.hpp"
#include "omniflight_planning/mission.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::cli {

/// The verdicts of flight.json, best first.
inline constexpr const char* kFlown = "flown";
inline constexpr const char* kFlownBadly = "flown_badly";  ///< to the end, and outside its bounds
inline constexpr const char* kLost =
    "lost";  ///< left its reference (and the failsafe ended it, or not), or hit the map
inline constexpr const char* kNotFlown =
    "not flown to the end";  ///< a component, the recording or the user ended it

/// Share of the flight that a rotor may be at its limit, where the mission keeps headroom.
inline constexpr double kMostAtLimit = 0.01;

struct FlightVerdict {
  std::string word = kFlown, reason;  ///< the first reason; empty when flown
  nlohmann::json figures;             ///< each figure beside its bound
  bool complete = true;               ///< the recording holds the whole plan
  std::vector<std::string> remarks;   ///< what happened beside the plan, a line each
};

/// What a flight is judged by.
struct Expected {
  const planning::Plan& plan;
  const planning::Mission& mission;
  const vehicle::Vehicle& vehicle;
  double after = 0;  ///< s that the plant goes on after the plan's end
};

FlightVerdict judge_flight(const Expected& expected, const recording::Recording& recording,
                           const FlightMetrics& metrics);

}  // namespace omniflight::cli
