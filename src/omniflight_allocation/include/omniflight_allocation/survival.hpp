// Which way of choosing weights and tilt survives a full roll, over its duration, the rate of the tilt and
// the thrust that rotors give less than the allocator believes (thesis, chapters 5.3 and 6, and beyond).
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "omniflight_allocation/closed_loop.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::allocation {

enum class TiltMethod {
  case_a,           ///< search from period to period, weights of case A
  case_b,           ///< the same with the weights of case B
  dynamic,          ///< the same with those of case B, of which W1 follows the position error (eq. 5.3)
  look_ahead,       ///< the tilt planned over the whole motion, dynamic weights
  look_ahead_told,  ///< the same, and the planner knows the loss of thrust; the allocator does not
};
inline constexpr std::array kTiltMethods{TiltMethod::case_a, TiltMethod::case_b, TiltMethod::dynamic,
                                         TiltMethod::look_ahead, TiltMethod::look_ahead_told};
const char* words(TiltMethod method);

/// Share of the believed thrust that rotors give, linear between the limits of the tilt.
struct ThrustShare {
  double at_low = 1, at_high = 1;  ///< in (0, 10]
  std::string words() const;
};

struct SurvivalConfig {
  std::vector<double> roll_times = {2, 3, 4, 6, 8, 12};  ///< s
  std::vector<double> tilt_steps = {to_radians(0.05), to_radians(0.1), to_radians(0.2),
                                    to_radians(0.3),  to_radians(0.5), to_radians(1.0)};  ///< rad a period
  std::vector<ThrustShare> shares = {{1, 1}, {0.85, 0.85}, {0.65, 0.65}, {0.35, 0.7}};
  double initial_tilt = to_radians(30.0);  ///< rad, of the searches and the plans
  double reserve = 0.4;                    ///< of the look-ahead, for a loss that it does not know
  double reserve_told = 0.1;               ///< of the one that is told the loss
  double left = 0.5;                       ///< m from the reference: lost
  double turned_away = to_radians(45.0);   ///< rad from the reference: lost
  LoopGains gains;
};

struct Survival {
  bool survived = false;
  double worst_error = 0, worst_angle = 0;  ///< m, rad
  double mean_power = 0;                    ///< W, of a flight that survives
};

/// Flights of one share and roll time and tilt step, one a method, in the order of kTiltMethods.
struct SurvivalCell {
  std::size_t share = 0, roll_time = 0, tilt_step = 0;  ///< indices into the config
  std::array<Survival, kTiltMethods.size()> flights;
  const Survival& of(TiltMethod method) const { return flights[static_cast<std::size_t>(method)]; }
};

struct SurvivalMap {
  SurvivalConfig config;
  std::vector<SurvivalCell> cells;  ///< shares, in them roll times, in them tilt steps
};

/// Flies the whole map; go_on(share done) after every cell, false ends it with an error. Refuses vehicles
/// that are not valid or do not tilt together, and configs out of range.
Result<SurvivalMap> survival_map(const vehicle::Vehicle& vehicle, const SurvivalConfig& config = {},
                                 const std::function<bool(double done)>& go_on = {});

/// Two methods over the cells of a map.
struct SurvivalComparison {
  int first = 0, second = 0;            ///< cells that each survives
  int only_first = 0;                   ///< survived by the first alone
  int both = 0, second_needs_less = 0;  ///< survived by both; of them, with less power of the second
  double lowest = 0, highest = 0;       ///< power of the second over that of the first, where both survive
};
SurvivalComparison compare(const SurvivalMap& map, TiltMethod first, TiltMethod second);

}  // namespace omniflight::allocation
