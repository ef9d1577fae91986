// Is a pose free, can it be hovered, and is a whole motion free? Motions are certified, not sampled.
#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_allocation/rotor_load.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_planning/deadline.hpp"
#include "omniflight_planning/map.hpp"
#include "omniflight_planning/tether.hpp"
#include "omniflight_planning/vehicle_spheres.hpp"

namespace omniflight::planning {

struct Pose {
  Vec3 p_WB = Vec3::Zero();  ///< m
  Quat q_WB = Quat::Identity();
};

/// On the straight line and the shortest rotation from a to b, s in [0, 1].
Pose interpolate(const Pose& a, const Pose& b, double s);
bool is_finite(const Pose& pose);

class ConvexScene;
class TriangleTree;
struct GridPose;
struct PackedVehicle;

/// What a rigid body moves among: triangles, which the voxels of the map hold, and where its origin may be.
struct BodySpace {
  std::shared_ptr<const TriangleTree> obstacles;
  /// Body and obstacles as convex parts, which tell what is valid.
  std::shared_ptr<const ConvexScene> parts = {};
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();         ///< m, of the origin of the body's frame
  std::shared_ptr<std::atomic<std::uint64_t>> looks = {};  ///< counts the poses looked at; may be absent
};

/// How close the vehicle comes to an obstacle, and where.
struct Clearance {
  double distance = 0.0;    ///< m, lower bound; negative in contact; at most the map's max_distance
  Vec3 p_W = Vec3::Zero();  ///< m, centre of the vehicle sphere that comes closest
};

/// Where a timed curve comes closest, and what it was checked with.
struct CurveCheck {
  bool free = false;
  bool out_of_time = false;
  double min_clearance = 0.0;  ///< m, least over knots 0.1 s apart, never below the margin when free
  double at = 0.0;             ///< s, when; the first violation when not free
  Vec3 p_W = Vec3::Zero();     ///< m, the vehicle sphere that comes closest then
  std::size_t witnesses = 0;   ///< places looked at
};

/// Constant after construction. Holds a reference to the map, which must outlive it.
class StateCheck {
 public:
  /// Less room than this beyond the margin counts as none: it bounds the number of steps.
  static constexpr double kLeastRoom = 2e-4;  // m

  /// headroom in [0, 1): share of every rotor's range that hovering must leave free; margin: m of clearance
  /// that every state must keep. Without `rotors` every attitude can be held.
  StateCheck(const DistanceMap& map, VehicleSpheres spheres,
             std::shared_ptr<const allocation::RotorLoad> rotors, double headroom, double margin);

  /// The same check with another margin [m].
  StateCheck with_margin(double margin) const;
  /// The same check with a tether, or with none: its limits are part of room(), valid() and what uses them,
  /// but not of clearance().
  StateCheck with_tether(std::optional<Tether> tether) const;

  /// The same check of a vehicle whose tilt may be any of several: these are its parts at all of them, and an
  /// attitude can be held that one of `rotors` can hold.
  StateCheck with_tilts(VehicleSpheres spheres,
                        std::vector<std::shared_ptr<const allocation::RotorLoad>> rotors) const;

  /// The same check among triangles: what the spheres leave open is measured between the body's triangles and
  /// these, and not the voxels that hold them. The spheres are those of a mesh; the map reaches a body's
  /// length beyond the box of positions.
  StateCheck among(BodySpace space) const;

  Clearance clearance(const Pose& pose) const;
  /// Distance [m] beyond the margin that is certainly free around every vehicle point; coarser than
  /// clearance() where there is plenty, so many times cheaper. Not positive when the margin is not kept.
  /// Spheres in the distance field tell most poses: certainly free, or certainly hit. What lies between is
  /// measured: the convex parts themselves against the cubes of the voxels. Where there is `enough` [m], that
  /// much may be told, for less time.
  double room(const Pose& pose, double enough = HUGE_VAL) const;
  bool hoverable(const Quat& q_WB) const;
  /// All attitudes between two that can be held, `angle` [rad] apart: by the slope of the load, and where
  /// that leaves too little, every 2 degrees.
  bool hoverable_between(const Quat& a, const Quat& b, double angle) const;
  /// Of a body's origin: whether it is in its box. Always true of a vehicle.
  bool in_space(const Pose& pose) const;
  /// Finite and at least `margin` away from everything, at whatever attitude.
  bool clear(const Pose& pose) const;
  /// Finite, at least `margin` away from everything and hoverable.
  bool valid(const Pose& pose) const;
  /// Conservative advancement over the whole motion of interpolate(a, b, .): no pose between the ones looked
  /// at can come closer than the margin.
  bool motion_valid(const Pose& a, const Pose& b) const;
  /// Conservative advancement along the curve itself, with speeds bounded by its Bernstein control points.
  /// Not free and out_of_time when the deadline passes before it is done.
  CurveCheck curve(const Trajectory& trajectory, const Deadline& deadline = {}) const;
  /// The same without looking for the least clearance of a free curve, for half of the time.
  CurveCheck advance_along(const Trajectory& trajectory, const Deadline& deadline = {}) const;

  /// Which limit of the tether a pose violates; nothing where none.
  std::optional<TetherConflict> tether_conflict(const Pose& pose) const;

  const DistanceMap& map() const { return map_; }
  const VehicleSpheres& spheres() const { return spheres_; }
  double alpha() const { return rotors_ ? rotors_->alpha() : 0.0; }  ///< rad
  double margin() const { return margin_; }                          ///< m
  /// m, box that the body's origin may be in; nothing: the map.
  const std::optional<BodySpace>& space() const { return space_; }

 private:
  GridPose in_grid(const Pose& pose) const;
  float voxels(double length) const;  ///< of a length [m]
  /// The clearance, or `best` where that is no larger; where most poses have more, this takes less time.
  Clearance nearest(const Pose& pose, Clearance best) const;
  double room_of_vehicle(const Pose& pose, double enough) const;
  /// Of a body among triangles.
  double room_of_body(const Pose& pose, double enough) const;
  /// Distance [m] of a part to the voxels, or `enough` where it is at least that; no more than `low` is told
  /// as any number up to there.
  double exact(const SphereGroup& group, const Vec3& p_WB, const Mat3& R_WB, double low, double enough) const;
  double exact_triangles(const SphereGroup& group, const Vec3& p_WB, const Mat3& R_WB, double low,
                         double enough) const;

  const DistanceMap& map_;
  VehicleSpheres spheres_;
  std::shared_ptr<const PackedVehicle> packed_;
  std::shared_ptr<const allocation::RotorLoad> rotors_;
  std::vector<std::shared_ptr<const allocation::RotorLoad>> other_tilts_;
  double headroom_, margin_;
  std::optional<Tether> tether_ = {};
  std::optional<BodySpace> space_ = {};
};

/// Upper bound [m/s] of the speed of any vehicle point within `radius` [m] of the body origin between two
/// knots.
double speed_bound(const TrajectoryKnot& k0, const TrajectoryKnot& k1, double radius);

}  // namespace omniflight::planning
