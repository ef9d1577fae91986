// From what is measured of a flight to what is wrong with it. Pure: limits and measurements in, faults out.
#pragma once

#include <omniflight_core/frames.hpp>
#include <optional>

#include "omniflight_safety/failsafe.hpp"

namespace omniflight::safety {

/// A box that the vehicle's reference point stays in.
struct Fence {
  Vec3 min = Vec3::Constant(-1e9);  ///< m, world axes
  Vec3 max = Vec3::Constant(1e9);   ///< m
  double margin = 0.5;              ///< m beyond it at which the vehicle counts as out of control
};

/// How far p lies outside the fence [m, largest over the axes]; negative inside; NaN counts as far outside.
double outside(const Fence& fence, const Vec3& p_W);

struct Limits {
  double pose_stale_s =
      0.3;  ///< s, age of the newest believable pose; beyond any drop-out of a working system
  double imu_stale_s = 0.05;     ///< s; beyond the period of the slowest IMU
  double command_stale_s = 0.0;  ///< s, age of the newest rotor command; 0 = not judged
  double innovation_m = 0.5;     ///< m, between pose and estimate
  double battery_low_V = 0.0;    ///< V, 0 = not judged
  double battery_empty_V = 0.0;  ///< V, 0 = not judged
  double missed_share = 0.05;    ///< of the control periods
  double hover_load = 0.97;      ///< of the rotors left after a loss; beyond it nothing is left to steer with
  Fence fence;
};

enum class Wish : std::uint8_t { none, hold, land, stop, cut };

/// Measured at one instant. What is not known is empty and no fault, except that an age that is not finite is
/// one.
struct Vitals {
  double pose_age_s = 0.0;
  double imu_age_s = 0.0;
  double command_age_s = 0.0;
  double innovation_m = 0.0;
  double missed_share = 0.0;
  std::optional<double> battery_V;
  std::optional<Vec3> p_W;  ///< m, estimated position
  Wish wish = Wish::none;
  bool recorder = true, planner = true, boards = true, clock = true;
  bool board_emergency = false;
  double hover_load = 0.0;  ///< share of their range that the rotors left need to hover; 0: none is lost
};

FaultSet judge(const Limits& limits, const Vitals& vitals);

}  // namespace omniflight::safety
