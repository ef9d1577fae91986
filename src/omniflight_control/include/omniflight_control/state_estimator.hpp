// What the controller asks of an estimator, whichever it is.
#pragma once

#include "omniflight_core/frames.hpp"

namespace omniflight::control {

/// State from inertial samples and poses that come late. Time is an argument.
class StateEstimator {
 public:
  virtual ~StateEstimator() = default;

  /// Inertial sample at t [s]: specific force [m/s^2] and angular velocity [rad/s], body axes. Samples that
  /// are not finite or not later than the last one are ignored and counted.
  virtual void add_imu(double t, const Vec3& specific_force_B, const Vec3& gyro_B) = 0;
  /// Pose measured at t [s], which may lie in the past. The first one initialises the estimate.
  virtual void add_mocap(double t, const Vec3& p_WB, const Quat& q_WB) = 0;

  virtual bool ready() const = 0;
  virtual const RigidState& state() const = 0;
  virtual double time() const = 0;            ///< s, of the last inertial sample
  virtual double last_mocap() const = 0;      ///< s, when the last accepted pose was taken
  virtual const Vec3& gyro_bias() const = 0;  ///< rad/s, body axes
  virtual unsigned long refused() const = 0;  ///< samples and poses that were ignored
};

}  // namespace omniflight::control
