// Vectors, rotations and rigid-body state in monogram notation (docs/reference/notation.md).
// World W: east, north, up (REP-103). Body B: x forward, y left, z up, origin at the nominal centre of mass.
// SI units and radians everywhere inside.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>

namespace omniflight {

using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Quat = Eigen::Quaterniond;

inline constexpr double kGravity = 9.81;  ///< m/s^2; the value with which the thesis's figures reproduce
inline constexpr double kPi = 3.14159265358979323846;

/// Degrees are for people: files, messages and tests.
constexpr double to_radians(double degrees) { return degrees * kPi / 180.0; }
constexpr double to_degrees(double radians) { return radians * 180.0 / kPi; }

/// Matrix of the cross product: skew(a) * b == a.cross(b).
inline Mat3 skew(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}
/// Inverse of skew for the antisymmetric part of m.
inline Vec3 vee(const Mat3& m) { return 0.5 * Vec3(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)); }

/// Rotation by the vector phi [rad] (axis times angle), as a unit quaternion.
Quat exp_rotation(const Vec3& phi);
/// Shortest rotation that turns the direction of `from` into that of `to`. Quat::FromTwoVectors, compiled
/// once: it holds a singular value decomposition, which costs every source that names it some seconds.
Quat shortest_rotation(const Vec3& from, const Vec3& to);
/// Rotation vector [rad] of q, angle in [0, pi].
Vec3 log_rotation(const Quat& q);

/// Right Jacobian of SO(3): body rate = right_jacobian(phi) * d(phi)/dt for R = exp(phi).
Mat3 right_jacobian(const Vec3& phi);
/// Inverse of right_jacobian, valid for |phi| < 2 pi.
Mat3 right_jacobian_inverse(const Vec3& phi);
/// d/dt of right_jacobian(phi) times dphi [rad/s], so that the body's angular acceleration [rad/s^2] is
/// right_jacobian(phi) * d2(phi)/dt2 plus this. A symmetric difference along phi(t), exact to about 1e-10.
Vec3 jacobian_rate_times(const Vec3& phi, const Vec3& dphi);

/// Fixed-axis roll, pitch, yaw [rad] about world x, y, z (REP-103), R = Rz(yaw) Ry(pitch) Rx(roll).
Vec3 roll_pitch_yaw(const Quat& q_WB);
/// Inverse of roll_pitch_yaw; rpy [rad].
Quat from_roll_pitch_yaw(const Vec3& rpy);

/// Pose and velocity of a rigid body.
struct RigidState {
  Vec3 p_WB = Vec3::Zero();      ///< m, position of the body origin in the world
  Quat q_WB = Quat::Identity();  ///< attitude, world <- body
  Vec3 v_WB_W = Vec3::Zero();    ///< m/s, velocity, in world axes
  Vec3 w_WB_B = Vec3::Zero();    ///< rad/s, angular velocity, in body axes
};

/// True when every number of the state is finite and the quaternion is not zero.
bool is_finite(const RigidState& state);
/// The first component for which is_finite is false, with value and unit ("velocity y is nan m/s"); empty
/// when there is none.
std::string what_is_not_finite(const RigidState& state);

/// What a controller is asked to follow at one instant.
struct Reference {
  Vec3 p_WB = Vec3::Zero();      ///< m, position of the body origin in the world
  Quat q_WB = Quat::Identity();  ///< attitude, world <- body
  Vec3 v_WB_W = Vec3::Zero();    ///< m/s, world axes
  Vec3 w_WB_B = Vec3::Zero();    ///< rad/s, in the axes of the reference body frame
  Vec3 a_WB_W = Vec3::Zero();    ///< m/s^2, world axes
  Vec3 dw_WB_B = Vec3::Zero();   ///< rad/s^2, in the axes of the reference body frame
  double alpha = 0.0;            ///< rad, tilt the plan assumed
};

}  // namespace omniflight
