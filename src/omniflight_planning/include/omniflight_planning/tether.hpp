// A tether from a fixed anchor (the floor, or an apex above) to the vehicle: limits and weight.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/trajectory.hpp"
#include "omniflight_planning/map.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

/// Counts as the straight segment from anchor to attachment; sag of a slack tether is not modelled.
struct Tether {
  Vec3 anchor_W = Vec3::Zero();       ///< m
  Vec3 attachment_B = Vec3::Zero();   ///< m
  double length = 0.0;                ///< m
  double linear_mass = 0.0;           ///< kg/m
  Vec3 cone_axis_B = -Vec3::UnitZ();  ///< unit, axis of the cone in which the tether may leave the vehicle
  double cone = kPi;                  ///< rad, half angle of that cone
  double reserve = 0.0;               ///< m, that every vehicle point may be off its reference
  double twist = HUGE_VAL;            ///< rad, that may accumulate about the tether from the start

  Vec3 attachment_W(const Vec3& p_WB, const Quat& q_WB) const { return p_WB + q_WB * attachment_B; }
  double mass() const { return length * linear_mass; }  ///< kg
  /// Radius [m] about the body origin that holds what is within `radius` of it and the attachment.
  double reach(double radius) const { return std::max(radius, attachment_B.norm()); }
};

/// Within this distance of the anchor the tether may touch what it is tied to.
inline constexpr double kTiedWithin = 0.3;  // m

/// Where the segment begins to keep its clearance, towards the attachment at `end` [m].
Vec3 loose_from(const Tether& tether, const Vec3& end);

/// Way [m] that every vehicle point may move before the length or the cone is violated, at least, beyond the
/// reserve; not positive where one is. `reach` [m] is a radius about the body origin that holds the
/// attachment.
double tether_slack(const Tether& tether, double reach, const Vec3& p_WB, const Quat& q_WB);

/// Lower bound [m] of the distance of the segment, beyond kTiedWithin of the anchor, to the map's voxels, or
/// `enough` where it is larger. A motion of the attachment by d changes the distance by no more than d.
double tether_distance(const Tether& tether, const DistanceMap& map, const Vec3& p_WB, const Quat& q_WB,
                       double enough);

/// A limit that a pose violates.
struct TetherConflict {
  bool too_short = false;
  std::string words;  ///< with values and units
};
/// `near` [m] is the distance of the segment, from loose_from() on, to the voxels, of which `margin` [m] must
/// be left; `reach` [m] as of tether_slack. Nothing where no limit is violated.
std::optional<TetherConflict> tether_conflict(const Tether& tether, double near, double margin, double reach,
                                              const Vec3& p_WB, const Quat& q_WB);

/// What a flight asks of the tether.
struct TetherUse {
  double length = 0.0;    ///< m, that there is
  double longest = 0.0;   ///< m from anchor to attachment, on the knots
  double twist = 0.0;     ///< rad, largest amount accumulated about the tether since the start
  double twist_at = 0.0;  ///< s, when
  double mass = 0.0;      ///< kg of the whole tether, which the rotors can carry
};
/// Twist: integral of the body rate along the segment.
TetherUse tether_use(const Tether& tether, const std::vector<TrajectoryKnot>& knots);

/// What the twist exceeds, with when and by how much; nothing where it keeps its limit to a millionth.
std::optional<std::string> twist_conflict(const Tether& tether, const TetherUse& use);

/// The vehicle with the whole mass of the tether as a point mass at the attachment. The rotors' load is
/// convex in the mass carried, so a motion within limits with all of it and with none is so with any part of
/// it.
vehicle::Vehicle carrying(const vehicle::Vehicle& vehicle, const Tether& tether);

}  // namespace omniflight::planning
