// What the controller asks of an estimator, whichever it is.
#pragma once

#include "omniflight_core/frames.hpp"

namespace omniflight::control {

/// What an estimator takes, by each axis: beyond every sensor, and small enough that nothing overflows.
struct SensorLimits {
  static constexpr double specific_force = 1e4;  ///< m/s^2
  static constexpr double rate = 1e3;            ///< rad/s
  static constexpr double position = 1e5;        ///< m
  static constexpr double time = 1e9;            ///< s, on both sides of zero
};

/// Whether a sample or a pose is finite and within the limits; of a quaternion that has a direction: its
/// length is 0.5 to 2.
bool is_usable(double t, const Vec3& specific_force_B, const Vec3& gyro_B);
bool is_usable(double t, const Vec3& p_WB, const Quat& q_WB);

/// State from inertial samples and poses that come late. Time is an argument.
class StateEstimator {
 public:
  virtual ~StateEstimator() = default;

  /// Inertial sample at t [s]: specific force [m/s^2] and angular velocity [rad/s], body axes. Samples that
  /// are not usable or not later than the last one are ignored and counted.
  virtual void add_imu(double t, const Vec3& specific_force_B, const Vec3& gyro_B) = 0;
  /// Pose measured at t [s], which may lie in the past. The first one initialises the estimate. One that
  /// is not usable is ignored and counted.
  virtual void add_mocap(double t, const Vec3& p_WB, const Quat& q_WB) = 0;

  virtual bool ready() const = 0;
  virtual const RigidState& state() const = 0;
  virtual double time() const = 0;            ///< s, of the last inertial sample
  virtual double last_mocap() const = 0;      ///< s, when the last accepted pose was taken
  virtual const Vec3& gyro_bias() const = 0;  ///< rad/s, body axes
  virtual unsigned long refused() const = 0;  ///< samples and poses that were ignored
};

}  // namespace omniflight::control
