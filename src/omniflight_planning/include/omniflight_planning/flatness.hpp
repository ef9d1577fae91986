// Vehicles with one direction of force are differentially flat in the position of their centre of mass and in
// their heading: the attitude follows from the acceleration (Mellinger and Kumar 2011).
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "omniflight_planning/timing.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

/// What the motion of an underactuated vehicle follows from.
struct FlatVehicle {
  Vec3 thrust_axis_B = Vec3::UnitZ();  ///< unit
  Vec3 p_BBcm = Vec3::Zero();          ///< m, centre of mass

  /// Attitude at rest with a heading [rad]: the thrust axis upright.
  Quat upright(double heading) const;
  /// Heading [rad] of an attitude in which the vehicle can rest; nothing when its thrust axis leans by more
  /// than `tolerance` [rad].
  std::optional<double> heading(const Quat& q_WB, double tolerance = 1e-6) const;
  /// Angle [rad] of the thrust axis from upright.
  double lean(const Quat& q_WB) const;
};

/// Nothing for a vehicle that commands force and torque independently at this tilt [rad], and for one without
/// torque about every axis, which has no flat outputs here.
Result<std::optional<FlatVehicle>> flat_vehicle(const vehicle::Vehicle& vehicle, double alpha);

/// Position of the centre of mass [m] and heading [rad], with derivatives by time: [0] the value, [1] by s,
/// ... The heading is used up to its second derivative.
using FlatMotion = std::array<Eigen::Vector4d, 5>;

/// Motion of the body origin. The attitude swings the upright one by the shortest way to where the thrust
/// points; its rates are exact derivatives. Singular only in a fall as fast as gravity, where there is no
/// thrust.
Reference flat_reference(const FlatMotion& motion, const FlatVehicle& vehicle);

/// Four times continuously differentiable curve through upright poses: quintic spline through the centres of
/// mass and headings over the chord length, so that the attitudes that follow are twice differentiable.
/// Between two poses it is the straight line.
class FlatCurve {
 public:
  /// At least two poses, all upright; neighbours that coincide are merged.
  FlatCurve(const std::vector<Pose>& poses, const FlatVehicle& vehicle);
  ~FlatCurve();
  FlatCurve(FlatCurve&&) noexcept;
  FlatCurve& operator=(FlatCurve&&) noexcept;

  double length() const;  ///< m, with 0.3 m a radian
  /// Value and four derivatives by the parameter u in [0, length()].
  FlatMotion at(double u) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rides a curve from rest to rest with u = L s^5 (126 - 420 s + 540 s^2 - 315 s^3 + 70 s^4), at rest up to
/// the fourth derivative at both ends, in the shortest time (a whole number of knot periods) that keeps every
/// limit, the lean among them, at every knot. Fails as `ride` does.
Result<std::vector<TrajectoryKnot>> ride(const FlatCurve& curve, const FlatVehicle& vehicle,
                                         const Rotors& rotors, const MotionLimits& limits,
                                         const Deadline& deadline = {});

/// Largest angle [rad] of the thrust axis from upright on the knots.
double largest_lean(const std::vector<TrajectoryKnot>& knots, const FlatVehicle& vehicle);

}  // namespace omniflight::planning
