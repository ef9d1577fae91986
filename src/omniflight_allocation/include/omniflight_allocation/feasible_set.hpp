// What a design can do: feasible force and torque sets over the tilt, mass limit, omnidirectional tilt.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "omniflight_allocation/wrench_set.hpp"

namespace omniflight::allocation {

/// The sets at one tilt. The four torque definitions differ; each is named by what it holds fixed.
struct DesignPoint {
  double alpha = 0;                    ///< rad
  int rank = 0;                        ///< of the allocation matrix; 6 = fully actuated
  SetMeasures force_at_zero_torque;    ///< N
  SetMeasures torque_at_zero_force;    ///< Nm
  SetMeasures torque_at_hover;         ///< Nm, while m g acts upright
  SetMeasures torque_at_any_attitude;  ///< Nm, left in the worst attitude while m g is carried
  double mass_limit = 0;  ///< kg, largest mass that can hover in every attitude (torque about zero left)
  std::vector<Vec3> force_vertices, torque_vertices;  ///< N, Nm; of the first two sets, body axes
  std::vector<std::array<int, 3>> force_triangles, torque_triangles;  ///< their surfaces, see triangles()
};

struct DesignResult {
  std::string vehicle;
  double mass = 0;   ///< kg
  double f_max = 0;  ///< N, the limit that was used; 0: each rotor's own
  std::vector<DesignPoint> points;
  /// rad, smallest tilt at which the mass can hover in every attitude; empty when there is none within the
  /// limits.
  std::optional<double> omnidirectional_tilt;
};

/// f_max [N] and mass [kg]: 0 takes the vehicle's. Refuses tilts outside the vehicle's limits [rad].
Result<DesignResult> design(const vehicle::Vehicle& vehicle, const std::vector<double>& alphas,
                            double f_max = 0, double mass = 0);

/// Smallest tilt [rad] at which mass [kg] can hover in every attitude; scan in steps of one degree, then
/// bisection.
Result<std::optional<double>> smallest_omnidirectional_tilt(const vehicle::Vehicle& vehicle, double mass,
                                                            double f_max = 0);

/// Schema omniflight.design/1: tilts in degrees, shares as fractions.
void to_json(nlohmann::json& json, const DesignResult& result);

}  // namespace omniflight::allocation
