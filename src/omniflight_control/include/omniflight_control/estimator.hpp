// State from inertial measurements and delayed motion capture: a fixed-gain observer.
#pragma once

#include <array>

#include "omniflight_core/frames.hpp"

namespace omniflight::control {

struct EstimatorConfig {
  double position_bandwidth = 25.0;  ///< rad/s, how fast motion capture corrects position and velocity
  double attitude_bandwidth = 25.0;  ///< rad/s
  double gyro_bias_gain = 20.0;      ///< 1/s^2, 0 switches bias estimation off
  double gravity = kGravity;         ///< m/s^2
};

/// Integrates accelerometer and gyroscope (trapezoidal), and corrects with motion capture at the time it was
/// taken: the estimate of that instant is kept in a ring of half a second. Allocates nothing.
class Estimator {
 public:
  explicit Estimator(const EstimatorConfig& config) : config_(config) {}

  /// Inertial sample at t [s]: specific force [m/s^2] and angular velocity [rad/s], body axes. Samples that
  /// are not finite or not later than the last one are ignored and counted.
  void add_imu(double t, const Vec3& specific_force_B, const Vec3& gyro_B);
  /// Pose measured at t [s], which may lie in the past. The first one initialises the estimate.
  void add_mocap(double t, const Vec3& p_WB, const Quat& q_WB);

  bool ready() const { return ready_; }
  const RigidState& state() const { return state_; }
  double time() const { return time_; }              ///< s, of the last inertial sample
  double last_mocap() const { return mocap_time_; }  ///< s, when the last accepted pose was taken
  const Vec3& gyro_bias() const { return gyro_bias_; }
  unsigned long refused() const { return refused_; }

 private:
  struct Past {
    double t;
    Vec3 p;
    Quat q;
  };
  static constexpr std::size_t kPast = 512;

  EstimatorConfig config_;
  RigidState state_;
  Vec3 gyro_bias_ = Vec3::Zero(), last_force_ = Vec3::Zero(), last_gyro_ = Vec3::Zero();
  double time_ = -1.0, mocap_time_ = -1.0;
  bool ready_ = false, has_imu_ = false;
  std::array<Past, kPast> past_;
  std::size_t past_count_ = 0;
  unsigned long refused_ = 0;
};

}  // namespace omniflight::control
