// State from inertial measurements and delayed motion capture: a fixed-gain observer.
#pragma once

#include <array>

#include "omniflight_control/state_estimator.hpp"

namespace omniflight::control {

struct EstimatorConfig {
  double position_bandwidth = 25.0;  ///< rad/s, how fast motion capture corrects position and velocity
  double attitude_bandwidth = 25.0;  ///< rad/s
  double gyro_bias_gain = 20.0;      ///< 1/s^2, 0 switches bias estimation off
  double gravity = kGravity;         ///< m/s^2
};

/// Integrates accelerometer and gyroscope (trapezoidal), and corrects with motion capture at the time it was
/// taken: the estimate of that instant is kept in a ring of half a second. Allocates nothing.
class Estimator final : public StateEstimator {
 public:
  explicit Estimator(const EstimatorConfig& config) : config_(config) {}

  void add_imu(double t, const Vec3& specific_force_B, const Vec3& gyro_B) override;
  void add_mocap(double t, const Vec3& p_WB, const Quat& q_WB) override;

  bool ready() const override { return ready_; }
  const RigidState& state() const override { return state_; }
  double time() const override { return time_; }
  double last_mocap() const override { return mocap_time_; }
  const Vec3& gyro_bias() const override { return gyro_bias_; }
  unsigned long refused() const override { return refused_; }

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
