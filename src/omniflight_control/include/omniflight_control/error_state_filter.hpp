// State from inertial measurements and delayed motion capture: an error-state Kalman filter.
//
// Error: position, velocity, attitude (rotation vector in the body), biases of accelerometer and gyroscope.
// After Sola, "Quaternion kinematics for the error-state Kalman filter" (arXiv 1711.02508), section 6, with
// the local (body) attitude error of section 5.
#pragma once

#include <vector>

#include "omniflight_control/state_estimator.hpp"

namespace omniflight::control {

/// Densities are those of white noise: its integral over t has the standard deviation density * sqrt(t).
struct ErrorStateConfig {
  double accelerometer_noise = 0.02;  ///< m/s^2 per sqrt(Hz); includes vibration and scale
  double gyro_noise = 0.001;          ///< rad/s per sqrt(Hz)
  double accelerometer_walk = 0.005;  ///< m/s^3 per sqrt(Hz)
  double gyro_walk = 0.0005;          ///< rad/s^2 per sqrt(Hz)
  double position_noise = 0.0005;     ///< m, of a measured pose
  double attitude_noise = 0.0015;     ///< rad, of a measured pose, per axis
  double gate = 27.86;          ///< largest normalised innovation squared: 0.9999 of chi^2 with 6 degrees
  double recover_after = 0.25;  ///< s of refused poses alone, after which the covariance is opened
  double gravity = kGravity;    ///< m/s^2
};

/// The filter stands at the instant of the last accepted pose; the inertial samples since then are kept, and
/// the present state is what they make of it. A late pose is therefore applied at the instant it was taken,
/// and the samples since then are replayed. Allocates at construction only.
class ErrorStateFilter final : public StateEstimator {
 public:
  using Covariance = Eigen::Matrix<double, 15, 15>;  ///< p, v [m, m/s, world], theta [rad, body], b_a, b_g

  explicit ErrorStateFilter(const ErrorStateConfig& config);

  void add_imu(double t, const Vec3& specific_force_B, const Vec3& gyro_B) override;
  void add_mocap(double t, const Vec3& p_WB, const Quat& q_WB) override;

  bool ready() const override { return ready_; }
  const RigidState& state() const override { return state_; }
  double time() const override { return newest_.t; }
  double last_mocap() const override { return mocap_time_; }
  const Vec3& gyro_bias() const override { return now_.bg; }
  unsigned long refused() const override { return refused_; }

  const Vec3& accelerometer_bias() const { return now_.ba; }  ///< m/s^2, body axes
  /// Of the present state. Costs a replay; for tests and reports.
  Covariance covariance() const;
  /// Normalised innovation squared of the last pose that was judged; chi^2 with 6 degrees of freedom.
  double innovation() const { return innovation_; }
  /// Poses that the innovation test refused.
  unsigned long outliers() const { return outliers_; }

 private:
  struct Sample {
    double t = -1.0;
    Vec3 f = Vec3::Zero(), w = Vec3::Zero();
  };
  struct Nominal {
    Vec3 p = Vec3::Zero(), v = Vec3::Zero();
    Quat q = Quat::Identity();
    Vec3 ba = Vec3::Zero(), bg = Vec3::Zero();
  };
  static constexpr std::size_t kSamples = 1024;  ///< a second at 1 kHz

  const Sample& sample(std::size_t k) const { return samples_[(first_ + k) % kSamples]; }
  void push(const Sample& s);
  Sample between(const Sample& a, const Sample& b, double t) const;
  void advance(Nominal& x, const Sample& a, const Sample& b) const;
  void advance(Covariance& P, const Nominal& x, const Sample& a, const Sample& b) const;
  void advance_base(const Sample& to);
  void use_up_oldest();
  void replay();
  bool update(const Vec3& e_p, const Vec3& e_R);
  void open_covariance();
  void publish();

  ErrorStateConfig config_;
  std::vector<Sample> samples_;  ///< ring of those after base_sample_
  std::size_t first_ = 0, count_ = 0;
  Sample base_sample_, newest_;
  Nominal base_, now_;
  Covariance P_ = Covariance::Zero();  ///< of base_
  RigidState state_;
  double mocap_time_ = -1.0, heard_time_ = -1.0, innovation_ = 0.0;
  double refused_since_ = -1.0;  ///< s, of the first refused pose since an accepted one; < 0: none
  bool ready_ = false, has_imu_ = false;
  unsigned long refused_ = 0, outliers_ = 0;
};

}  // namespace omniflight::control
