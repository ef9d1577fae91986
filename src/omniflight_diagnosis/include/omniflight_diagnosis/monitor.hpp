// Online monitoring: wrench residual, rotor speed errors and sensor ages during the flight. Causal, bounded
// in memory and latency. Time is an argument; nothing here waits, logs or knows the bus.
#pragma once

#include <array>
#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_diagnosis/options.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// The limits are chosen, not derived: sigma is a tolerance of the vehicle file (Monitor::sigma), not the
/// noise of the filtered residual, so that a limit in sigma has no false-alarm rate of its own.
struct MonitorOptions {
  Tolerance tolerance;               ///< of vehicle and sensors; gives the sigma of the wrench residual
  Vec3 imu_position = Vec3::Zero();  ///< m, body: where the accelerometer is
  double gravity = kGravity;         ///< m/s^2
  double grid_hz = 200;              ///< signals are interpolated to this rate
  double cutoff_hz = 2;              ///< causal Butterworth low pass of the residuals, 4th order
  double max_gap_s = 0.08;           ///< a longer gap between samples resets the low pass
  double settle_s = 0.3;             ///< nothing is judged for this time after release
  double confirm_s = 0.2;            ///< a limit must be exceeded for this time
  double warn_sigma = 4;             ///< residual over sigma that is a warning
  double error_sigma = 10;           ///< residual over sigma that is an error
  double warn_speed = 0.12;          ///< nominal minus measured rotor speed over largest speed: warning
  double error_speed = 0.25;         ///< the same, error
  double imu_stale_s = 0.1;     ///< age of the last IMU sample that is a warning; four times that is an error
  double mocap_stale_s = 0.2;   ///< the same for poses
  double rotors_stale_s = 0.2;  ///< the same for rotor speeds
  double mocap_frozen_s = 0.2;  ///< an unchanged pose under new stamps for this time is a warning
};

/// Levels of diagnostic_msgs/DiagnosticStatus.
enum class Level : std::uint8_t { ok = 0, warn = 1, error = 2, stale = 3 };
const char* to_string(Level level);

/// State of one monitored quantity, as a DiagnosticStatus carries it.
struct Check {
  struct Value {
    std::string key;  ///< with its unit: "force_z [N]"
    double value = 0;
  };
  std::string name;  ///< "wrench balance", "motors", "sensors"
  Level level = Level::stale;
  std::string message;
  std::vector<Value> values;
};

/// Buffer of time-stamped samples with linear interpolation. Keeps a few seconds at most.
class SampleLine {
 public:
  /// Appends a value at t [s]. Returns false and ignores it when it is not finite or not newer than the last.
  bool add(double t, const Eigen::Ref<const Eigen::VectorXd>& value);
  bool empty() const { return samples_.empty(); }
  double first() const { return samples_.front().first; }
  double last() const {
    return samples_.empty() ? -std::numeric_limits<double>::infinity() : samples_.back().first;
  }
  /// Interpolates at t [s] into `value`; returns the gap [s] between the two samples used. Requires
  /// first() <= t <= last().
  double at(double t, Eigen::VectorXd& value) const;
  /// Last value at or before t [s] (zero-order hold); false when there is none.
  bool held(double t, Eigen::VectorXd& value) const;
  /// Drops samples that are not needed for times >= t [s].
  void forget_before(double t);
  void clear() { samples_.clear(); }

 private:
  std::deque<std::pair<double, Eigen::VectorXd>> samples_;
};

/// Alarm with confirmation time and hysteresis: on after `value` has exceeded `limit` for confirm_s [s], off
/// after it has been below 0.7 of the limit for as long.
class Trip {
 public:
  void update(double t, double value, double limit, double confirm_s);
  bool on() const { return on_; }
  void reset() { *this = Trip(); }

 private:
  bool on_ = false;
  double since_ = -1;
};

/// Samples may arrive in any order of topics, and assess() may be called at any time. add_*() copies the
/// sample; assess() processes what has arrived since. The residual lags by the delay of the slower of IMU and
/// rotor telemetry, plus delay_s().
class Monitor {
 public:
  /// Errors: bad_input for options out of range, naming the field.
  static Result<Monitor> create(const vehicle::Vehicle& vehicle, const MonitorOptions& options = {});

  /// Specific force [m/s^2] and rate [rad/s] at t [s], body axes.
  void add_imu(double t, const Vec3& specific_force, const Vec3& rate);
  /// Position [m, world] and attitude (world <- body) at t [s].
  void add_mocap(double t, const Vec3& position, const Quat& attitude);
  /// Measured speeds [rad/s, signed], one a rotor, and rotor tilt [rad] at t [s].
  void add_rotors(double t, std::span<const double> speed, double alpha);
  /// Commanded speeds [rad/s, signed], one a rotor, valid from t [s] on.
  void add_command(double t, std::span<const double> speed);

  /// State at t [s], which must not decrease between calls. `free`: no ground contact and no holding force.
  /// Always three checks, in the order wrench balance, motors, sensors.
  const std::array<Check, 3>& assess(double t, bool free);

  /// Group delay of the low pass [s].
  double delay_s() const;
  /// Last low-passed wrench residual [N, Nm], body axes, about the body origin.
  const Vec6& residual() const { return filtered_; }
  /// Sigma of each channel of the residual from the tolerances [N, Nm].
  const Vec6& sigma() const { return sigma_; }

 private:
  Monitor(const vehicle::Vehicle& vehicle, const MonitorOptions& options);
  void advance_wrench(double t);
  void advance_motors(double t);
  void start_anew();
  void assess_wrench(double t);
  void assess_motors(double t);
  void assess_sensors(double t, bool free);

  vehicle::Vehicle vehicle_;
  MonitorOptions options_;
  std::size_t rotors_ = 0;
  Vec6 sigma_ = Vec6::Ones(), filtered_ = Vec6::Zero();
  SampleLine imu_, rotor_, command_;  ///< force and rate; speeds and tilt; commanded speeds
  CausalLowPass wrench_filter_, motor_filter_;
  Eigen::VectorXd lag_, deviation_;   ///< nominal speed [rad/s]; (measured - nominal) / largest speed [1]
  double next_ = -1;                  ///< s, next grid time of the wrench residual
  double motor_next_ = -1;            ///< the same for the motors
  double released_ = -1;              ///< s, time of release; -1 before it
  std::array<Trip, 6> warn_, error_;  ///< by channel
  std::vector<Trip> motor_warn_, motor_error_;
  double wrench_t_ = -1, motor_t_ = -1;       ///< s, of the last residual
  double mocap_t_ = -1, mocap_changed_ = -1;  ///< s
  Eigen::Matrix<double, 7, 1> pose_ = Eigen::Matrix<double, 7, 1>::Zero();
  std::array<Check, 3> checks_;
};

}  // namespace omniflight::diagnosis
