// Many flights of one plan in one process, eight at a time in the lanes of the vector unit: plant, control
// law and allocation, without sensors, estimator, failsafe and bus.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "omniflight_allocation/config.hpp"
#include "omniflight_allocation/look_ahead.hpp"
#include "omniflight_control/law.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_physics/effect.hpp"
#include "omniflight_simulation/plant.hpp"

namespace omniflight::campaign {

/// A moment of a flight from the begin of its plan on, for those who judge more than FlightFigures tells.
struct FlightMoment {
  std::size_t flight = 0;  ///< its number
  double along = 0;        ///< s, time of the plan
  RigidState state;        ///< true
  double alpha = 0;        ///< rad, tilt of the rotors
  vehicle::RotorVector u;  ///< N, commanded thrusts
};

/// What all flights have in common.
struct Loop {
  vehicle::Vehicle vehicle;   ///< of the plant
  vehicle::Vehicle believed;  ///< of the allocator
  simulation::PlantConfig plant;
  double control_period = 0.002;  ///< s, a whole multiple of plant.step
  double hold = 1.0;              ///< s that the body is held at the start
  double settle = 3.0;            ///< s in hover before the plan begins
  double duration = 10.0;         ///< s, whole flight
  std::string law = "full_pose";
  bool anti_windup = true;
  allocation::AllocatorConfig allocator;
  Trajectory trajectory;
  std::optional<allocation::TiltSchedule> schedule;  ///< of the tilt over the plan's time
  bool follow_plan = true;                           ///< else the tilt stays, or is searched
  std::function<void(const FlightMoment&)> watch;    ///< called every kLookEvery periods; may be empty
};

/// What differs.
struct OneFlight {
  physics::Model model;
  RigidState start;
  control::LawConfig law;
  std::uint64_t seed = 1;  ///< of effects that draw random numbers
};

/// What came of a flight. Errors are those of the true state, over the plan's motion, every kLookEvery
/// control periods.
struct FlightFigures {
  Vec3 position_rmse = Vec3::Zero();  ///< m, world
  Vec3 attitude_rmse = Vec3::Zero();  ///< rad, about body axes
  double worst_position = 0;          ///< m
  double worst_position_at = 0;       ///< s, flight time
  double worst_attitude = 0;          ///< rad
  double end_error = 0;               ///< m, largest in the last quarter of a second of the plan
  double mean_power = 0;              ///< W, mechanical
  double least_headroom = 1;          ///< share of the largest thrust that was free, of the rotor with least
  double share_at_limit = 0;          ///< share of the looks with a rotor at its limit
  std::optional<double> ended_early;  ///< s, when it was further than kGone from its reference
};
inline constexpr int kLookEvery = 5;
inline constexpr double kGone = 2.0;  ///< m from the reference: such a flight is not followed further

/// Flies them all. The figures of a flight depend neither on how many fly nor on what the others are.
/// stop() is asked now and then; once it is true, incomplete is returned.
/// Errors: what Plant, make_law and Allocator refuse, with the number of the flight.
Result<std::vector<FlightFigures>> fly_many(const Loop& loop, std::span<const OneFlight> flights,
                                            bool (*stop)() = nullptr);

}  // namespace omniflight::campaign
