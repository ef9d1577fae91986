// The residuals of a diagnosis while the flight goes on: causal, bounded in memory and latency. Time is an
// argument; nothing here waits, logs or knows the bus.
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

struct MonitorOptions {
  Tolerance tolerance;               ///< what one sigma of a wrench residual is
  Vec3 imu_position = Vec3::Zero();  ///< m, body: where the accelerometer is
  double gravity = kGravity;         ///< m/s^2
  double grid_hz = 200;              ///< signals are interpolated to this rate
  double cutoff_hz = 2;              ///< causal low pass of the residuals, 4th order
  double max_gap_s = 0.08;           ///< a longer gap in a signal starts the residual anew
  double settle_s = 0.3;             ///< after the release nothing is judged for so long
  double confirm_s = 0.2;            ///< a limit must be exceeded for so long
  double warn_sigma = 4;             ///< limits of the wrench, in sigma of the tolerance
  double error_sigma = 10;           ///<
  double warn_speed = 0.12;          ///< limits of command minus speed of a rotor, over its largest speed
  double error_speed = 0.25;         ///<
  double imu_stale_s = 0.1;     ///< age of the last sample that is a warning; four times that is an error
  double mocap_stale_s = 0.2;   ///<
  double rotors_stale_s = 0.2;  ///<
  double mocap_frozen_s = 0.2;  ///< the same pose under new stamps for so long is a warning
};

/// Levels of diagnostic_msgs/DiagnosticStatus.
enum class Level : std::uint8_t { ok = 0, warn = 1, error = 2, stale = 3 };
const char* to_string(Level level);

/// One thing that is watched, and how it is.
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

/// Measured or commanded values with their times; linear in between. Keeps a few seconds at most.
class SampleLine {
 public:
  /// Older than the last one, or not finite: ignored, false.
  bool add(double t, const Eigen::Ref<const Eigen::VectorXd>& value);
  bool empty() const { return samples_.empty(); }
  double first() const { return samples_.front().first; }
  double last() const {
    return samples_.empty() ? -std::numeric_limits<double>::infinity() : samples_.back().first;
  }
  /// Value at t, and the gap [s] between the samples around it. Needs first() <= t <= last().
  double at(double t, Eigen::VectorXd& value) const;
  /// The last value at or before t; false when there is none.
  bool held(double t, Eigen::VectorXd& value) const;
  /// Forgets what is not needed for times from t on.
  void forget_before(double t);
  void clear() { samples_.clear(); }

 private:
  std::deque<std::pair<double, Eigen::VectorXd>> samples_;
};

/// Turns on above a limit that holds for a while, off below 0.7 of it for as long.
class Trip {
 public:
  void update(double t, double value, double limit, double confirm_s);
  bool on() const { return on_; }
  void reset() { *this = Trip(); }

 private:
  bool on_ = false;
  double since_ = -1;
};

/// Feed it what arrives, in any order of topics; ask it at will. Adding costs a copy, asking what has come
/// since. Latency: what is missing on the slowest of IMU and rotor telemetry, plus delay_s().
class Monitor {
 public:
  /// Errors: bad_input for options out of range, naming the field.
  static Result<Monitor> create(const vehicle::Vehicle& vehicle, const MonitorOptions& options = {});

  void add_imu(double t, const Vec3& specific_force, const Vec3& rate);    ///< s, m/s^2, rad/s, body
  void add_mocap(double t, const Vec3& position, const Quat& attitude);    ///< s, m
  void add_rotors(double t, std::span<const double> speed, double alpha);  ///< s, rad/s signed, rad
  void add_command(double t, std::span<const double> speed);  ///< s from which it holds, rad/s signed

  /// How everything is at t [s]; free: nothing holds the vehicle. Always three checks, in the order wrench
  /// balance, motors, sensors. Times must not decrease.
  const std::array<Check, 3>& assess(double t, bool free);

  /// Group delay of the low pass [s].
  double delay_s() const;
  /// Residual [N, Nm, body] after the low pass, as last computed.
  const Vec6& residual() const { return filtered_; }
  /// Sigma of the tolerance by channel [N, Nm].
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
  Eigen::VectorXd lag_, deviation_;   ///< rad/s: nominal speed, and speed minus nominal over largest speed
  double next_ = -1;                  ///< s, grid time to compute next
  double motor_next_ = -1;            ///< the same for the motors
  double released_ = -1;              ///< s, or -1 while held
  std::array<Trip, 6> warn_, error_;  ///< by channel
  std::vector<Trip> motor_warn_, motor_error_;
  double wrench_t_ = -1, motor_t_ = -1;       ///< s, of the last residual
  double mocap_t_ = -1, mocap_changed_ = -1;  ///< s
  Eigen::Matrix<double, 7, 1> pose_ = Eigen::Matrix<double, 7, 1>::Zero();
  std::array<Check, 3> checks_;
};

}  // namespace omniflight::diagnosis
