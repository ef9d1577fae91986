// What a log tells about the vehicle that wrote it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

/// A rotor as the autopilot's allocation has it; body axes forward, left, up about the autopilot's origin.
struct RotorHint {
  Vec3 p_B = Vec3::Zero();           ///< m
  Vec3 axis_B = Vec3::UnitZ();       ///< direction of positive thrust
  int spin = 1;                      ///< +1: positive thrust exerts its reaction torque along the axis
  double drag_ratio = 0;             ///< m: torque over thrust
  std::optional<double> max_thrust;  ///< N; PX4's default of 6.5 is no statement
};

struct VehicleHints {
  std::string autopilot;             ///< "PX4 v1.14.0 on PX4_FMU_V6C"; empty when the log says nothing
  std::string airframe;              ///< "quadrotor"; empty: not told
  int rotor_count = 0;               ///< 0: not told
  std::vector<RotorHint> rotors;     ///< empty, or one for each rotor
  std::optional<double> mass;        ///< kg
  std::optional<Vec3> inertia;       ///< kg m2, principal, about body axes
  std::optional<double> hover_duty;  ///< 0..1, the autopilot's figure
  std::optional<int> battery_cells;
};

/// From the parameters of PX4 (CA_ROTOR*, MAV_TYPE, SIH_*, MPC_THR_HOVER, BAT*_N_CELLS; PX4's parameter
/// reference). Empty for recordings without parameters.
VehicleHints vehicle_hints(const Recording& recording);

}  // namespace omniflight::recording
