// Everything an effect may look at at one instant, and the wrench it answers with.
#pragma once

#include <array>
#include <span>

#include "omniflight_core/frames.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::physics {

struct Environment {
  double gravity = kGravity;  ///< m/s^2
  double air_density = 1.2;   ///< kg/m^3
  double floor_z = 0.0;       ///< m, world height of the floor
};

/// One rotor as the nominal model sees it.
struct RotorSituation {
  Vec3 p_BR, n_B;           ///< m; unit thrust axis at the present tilt, body frame
  Vec3 tilt_axis_B;         ///< unit, zero for a rotor that does not tilt
  double speed = 0;         ///< rad/s, signed
  double acceleration = 0;  ///< rad/s^2
  double thrust = 0;        ///< N, nominal law at this speed
  double spin = 1;
  double drag_ratio = 0;          ///< m
  double radius = 0;              ///< m
  double thrust_coefficient = 0;  ///< N/(rad/s)^2
  int board = 0;
};

/// Another multirotor nearby, at one instant of its track.
struct Neighbour {
  Vec3 p_WN = Vec3::Zero();  ///< m, its body origin in the world
};
inline constexpr int kMaxNeighbours = 4;

/// The vehicle at one instant. In a simulation the accelerations are unknown (zero) and effects that need
/// them answer with an added inertia; in a diagnosis they are measured.
struct Situation {
  double t = 0;  ///< s
  RigidState body;
  Mat3 R_WB = Mat3::Identity();
  Vec3 v_WB_B = Vec3::Zero();   ///< m/s, velocity in body axes
  Vec3 a_WB_B = Vec3::Zero();   ///< m/s^2, coordinate acceleration of the body origin in body axes
  Vec3 dw_WB_B = Vec3::Zero();  ///< rad/s^2
  /// Acceleration that was observed, where a_WB_B and dw_WB_B are predictions: it drives what an effect
  /// remembers, which acts on the vehicle only later. See memory_acceleration().
  bool observed = false;
  Vec3 observed_a_B = Vec3::Zero(), observed_dw_B = Vec3::Zero();
  Vec3 g_B = Vec3::Zero();      ///< m/s^2, gravity in body axes: R_WB^T (0, 0, -g)
  double alpha = 0;             ///< rad
  double mass = 0;              ///< kg, nominal
  Mat3 inertia = Mat3::Zero();  ///< kg m^2, nominal
  Environment environment;
  int rotor_count = 0;
  std::array<RotorSituation, vehicle::kMaxRotors> rotors;

  /// Who else flies here; set_neighbours() fills it from tracks, prepare() leaves it alone.
  int neighbour_count = 0;
  std::array<Neighbour, kMaxNeighbours> neighbours;

  const Vec3& memory_acceleration() const { return observed ? observed_a_B : a_WB_B; }
  const Vec3& memory_turn() const { return observed ? observed_dw_B : dw_WB_B; }  ///< rad/s^2

  std::span<const RotorSituation> all_rotors() const {
    return {rotors.data(), static_cast<std::size_t>(rotor_count)};
  }
  std::span<const Neighbour> all_neighbours() const {
    return {neighbours.data(), static_cast<std::size_t>(neighbour_count)};
  }
};

/// Fills everything that follows from vehicle, body state, tilt and signed rotor speeds [rad/s].
/// rotor_acceleration [rad/s^2] may be empty (zero).
void prepare(const vehicle::Vehicle& vehicle, const RigidState& body, double alpha,
             std::span<const double> rotor_speed, std::span<const double> rotor_acceleration,
             const Environment& environment, Situation& out);

/// Force and torque about the body origin, body axes; plus mass and inertia that move along:
/// wrench acting = (force, torque) - moving_inertia * (a_WB_B, dw_WB_B).
template <class T>
struct WrenchT {
  Eigen::Matrix<T, 3, 1> force_B = Eigen::Matrix<T, 3, 1>::Zero();   ///< N
  Eigen::Matrix<T, 3, 1> torque_B = Eigen::Matrix<T, 3, 1>::Zero();  ///< Nm
  T mass = T(0);                                                     ///< kg, at the body origin
  T lifted_mass = T(0);  ///< kg, at the body origin, moved along the world's vertical only
  bool has_inertia = false;
  Eigen::Matrix<T, 6, 6> inertia =
      Eigen::Matrix<T, 6, 6>::Zero();  ///< kg, kg m, kg m^2, beside the two masses

  bool moves_mass() const { return has_inertia || mass != T(0) || lifted_mass != T(0); }
  /// All of it: the inertia and the two masses.
  Eigen::Matrix<T, 6, 6> moving_inertia(const Situation& s) const;
  void add_at(const Vec3& p_B, const Eigen::Matrix<T, 3, 1>& f_B);
  /// Total wrench when the accelerations are known.
  Eigen::Matrix<T, 6, 1> at(const Situation& s) const;
};
using Wrench = WrenchT<double>;
template <>
inline void Wrench::add_at(const Vec3& p_B, const Vec3& f_B) {
  force_B += f_B;
  torque_B += p_B.cross(f_B);
}

/// Wrench of the rotors by the nominal law, force [N] then torque [Nm] about the body origin, body axes.
Vec6 rotor_wrench(const Situation& situation);

}  // namespace omniflight::physics
