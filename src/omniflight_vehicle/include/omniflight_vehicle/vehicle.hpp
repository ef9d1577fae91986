// A multirotor with fixed or tilting rotors: constant data and the geometry that follows from it.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::vehicle {

inline constexpr int kMaxRotors = 16;

/// Wrench of every rotor per newton of its thrust, 6 x n: rows force [N/N] then torque about the body origin
/// [Nm/N], body axes. Fixed capacity, so that hot loops allocate nothing.
using AllocationMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxRotors>;
/// One number a rotor, without allocation.
using RotorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRotors, 1>;

struct Rotor {
  Vec3 p_BR = Vec3::Zero();     ///< m, hub in the body frame
  Vec3 axis_B = Vec3::UnitZ();  ///< unit thrust axis at tilt 0, body frame
  bool tilts = false;
  Vec3 tilt_axis_B = Vec3::UnitX();  ///< unit; thrust axis at tilt alpha is Rot(tilt_axis, alpha) axis
  int spin = 1;  ///< +1: positive thrust exerts the reaction torque +drag_ratio*thrust along it
  double thrust_coefficient = 0;  ///< N/(rad/s)^2
  double drag_ratio = 0;          ///< m, reaction torque per thrust
  bool bidirectional = false;
  double min_thrust = 0;     ///< N, smallest magnitude that is held
  double max_thrust = 0;     ///< N, largest magnitude
  double radius = 0;         ///< m
  double time_constant = 0;  ///< s, first-order lag of the speed; 0 = ideal
  int board = 0;             ///< control board that drives it

  double max_speed() const { return std::sqrt(max_thrust / thrust_coefficient); }  ///< rad/s
  /// Lowest allowed thrust [N]: -max_thrust for a bidirectional rotor, min_thrust otherwise.
  double lower_thrust() const { return bidirectional ? -max_thrust : min_thrust; }
  /// Thrust [N] at a signed speed [rad/s]; a rotor that cannot reverse gives positive thrust either way.
  double thrust(double speed) const {
    return thrust_coefficient * speed * (bidirectional ? std::abs(speed) : speed);
  }
  /// Signed speed [rad/s] that gives a thrust [N].
  double speed(double thrust_N) const {
    const double magnitude = std::sqrt(std::abs(thrust_N) / thrust_coefficient);
    return thrust_N < 0 ? -magnitude : magnitude;
  }
};

enum class TiltKind { none, common, individual };

struct Tilt {
  TiltKind kind = TiltKind::none;
  double min = 0, max = 0;   ///< rad
  double rate = 0;           ///< rad/s; 0 = any
  double time_constant = 0;  ///< s, first-order lag of the servo behind its command; 0 = ideal
  double backlash = 0;       ///< rad, full width of the play between servo and rotors; 0 = none
};
inline constexpr double kMaxTiltTimeConstant = 2.0;           ///< s, the bound of a rotor's, too
inline constexpr double kMaxTiltBacklash = to_radians(20.0);  ///< rad, the bound of a proof world's, too

/// Another mass of the same vehicle, loaded as "vehicle@name".
struct MassVariant {
  std::string name;
  double mass = 0;  ///< kg
  std::string why;
};

/// A convex piece of the vehicle for collision checks: disc of a rotor or an arm/core capsule.
struct CollisionShape {
  enum class Kind { sphere, cylinder, box } kind = Kind::sphere;
  Vec3 p_BS = Vec3::Zero();      ///< m, centre
  Quat q_BS = Quat::Identity();  ///< cylinder axis is its z
  Vec3 size = Vec3::Zero();      ///< m; sphere: radius; cylinder: radius, length; box: full edges
};

struct Vehicle {
  std::string name;
  double mass = 0;                     ///< kg
  Mat3 inertia = Mat3::Zero();         ///< kg m^2, about the centre of mass, body axes
  Vec3 center_of_mass = Vec3::Zero();  ///< m, body frame
  std::vector<Rotor> rotors;
  Tilt tilt;
  std::vector<MassVariant> variants;      ///< all that the file lists, in its order, whichever was loaded
  std::vector<CollisionShape> collision;  ///< without the rotor discs
  std::map<std::string, std::string> provenance;
  /// How well numbers of the file are known, one standard deviation: "inertia" and "drag_torque" relative
  /// [1], "rotor_axis" [rad], ...; the kinds of the diagnosis' calibration. Only what the file tells.
  std::map<std::string, double> tolerance;
  std::string file;    ///< the YAML it was loaded from
  std::string sha256;  ///< of the YAML and the URDF together

  int rotor_count() const { return static_cast<int>(rotors.size()); }
  /// Unit thrust axis of rotor i at tilt alpha [rad], body frame.
  Vec3 rotor_axis(int i, double alpha) const;
  /// Force and torque per newton of thrust of each rotor about the body origin, at tilt alpha [rad].
  AllocationMatrix allocation_matrix(double alpha) const;
  RotorVector lower_thrusts() const;  ///< N
  RotorVector upper_thrusts() const;  ///< N
  /// Radius [m] of the smallest sphere about the body origin that holds every rotor disc and collision shape.
  double bounding_radius() const;
};

/// Options for loading: "field=value" overrides such as "mass=0.0397" or "rotors.drag_ratio=0.006" (all
/// rotors). spec is a name under configs/vehicles (optionally name@variant, "omnimorph@table_4_1") or a path
/// to a YAML. Errors name file, line, field and unit. Mass must be positive, inertia positive definite and
/// triangle-valid.
Result<Vehicle> load_vehicle(const std::string& spec, const std::vector<std::string>& overrides = {});

/// Names under configs/vehicles.
std::vector<std::string> vehicle_names();

/// Checks the physical validity that load_vehicle promises.
Status validate(const Vehicle& vehicle);

}  // namespace omniflight::vehicle
