// One conditioned recording: all signals on one time grid, with the samples that are usable and why others
// are not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_diagnosis/alignment_report.hpp"
#include "omniflight_diagnosis/options.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// Time window [from_s, to_s] that is excluded, and the reason.
struct Window {
  double from_s = 0, to_s = 0;
  std::string why;
};

struct ParameterValue {
  std::string name, symbol, unit;
  double value = 0, low = 0, high = 0;  ///< estimate and 95 % interval, in `unit`
};

/// Fault of a sensor, detected while the recording is conditioned.
struct SensorFault {
  std::string effect;   ///< id of the library, e.g. stale_samples
  std::string channel;  ///< "rotor1_speed", "vbat"
  std::string sentence;
  double share = 0;       ///< of the flight's samples or duration that it affects
  double log_factor = 0;  ///< ln Bayes factor against a sound sensor; 0 where `parameters` give it
  std::vector<ParameterValue> parameters = {};  ///< e.g. an offset; empty without one
  std::vector<std::string> rivals = {};         ///< causes that this recording cannot distinguish from it
};

/// Contiguous usable samples [begin, end) of the grid.
struct Segment {
  int begin = 0, end = 0;
};

/// Recorded rotor speed commands on their own time stamps.
struct CommandTrack {
  std::vector<double> t;  ///< s
  Eigen::MatrixXd value;  ///< rad/s, rotors x samples

  bool empty() const { return t.empty(); }
};

struct Flight {
  std::string file, sha256;
  double duration_s = 0;
  std::vector<std::string> signals;
  std::vector<Window> excluded;
  std::vector<SensorFault> faults;
  std::vector<std::string> notes;  ///< sentences: repairs, and consequences of missing signals

  double rate_hz = 0;  ///< of the grid
  double reach_s = 0;  ///< look-ahead of the interpolation of the slowest signal: its sample period
  /// Standard deviation [s] of the common smoothing kernel of all signals: interpolation, differences and
  /// block mean (docs/explanation/diagnosis_method.md, Feedback 1).
  double kernel_s = 0;
  std::vector<double> t;
  std::vector<physics::Situation> situation;  ///< state, rotors and accelerations at every grid time
  Eigen::MatrixXd specific_force;             ///< n x 3, m/s^2, body
  Eigen::MatrixXd rotor_speed;                ///< n x rotors, rad/s
  /// Recorded reference in its own body axes, n x k: velocity [m/s], specific force [m/s^2], rate [rad/s] and
  /// angular acceleration [rad/s^2], as far as recorded. It is exogenous: no disturbance moves it.
  Eigen::MatrixXd reference;
  /// n x 6, N and Nm: what noise of the sensors, one draw of it of the size that is told, does to the wrench
  /// residual. Empty where the noise of what the residual follows from is not told.
  Eigen::MatrixXd sensor_noise;
  Eigen::MatrixXd tracking_error;  ///< n x 3, m, position minus reference; empty without reference
  std::vector<Segment> segments;
  bool has_accelerometer = false, has_gyro = false, has_alpha = false, has_position = false;
  bool speed_from_command = false;  ///< no measured rotor speeds: they are commands through the nominal lag
  CommandTrack commands;            ///< set with speed_from_command
  bool thrust_modelled = false;  ///< thrust is modelled from duty cycles; its scale is fitted to this flight
  Eigen::VectorXd log_voltage;   ///< n, set with thrust_modelled: ln(voltage / its mean)
  std::vector<Alignment> alignment;
  double floor_z = 0;  ///< m, world height of the floor that is used
  /// m, world height of the body origin while standing; empty: floor told, or never stood
  std::optional<double> stood_at;

  int size() const { return static_cast<int>(t.size()); }
  int usable() const;  ///< samples in all segments
  bool has(const std::string& signal) const;
};

/// Conditions a recording: removes duplicated, frozen and clipped samples, corrects clocks, resamples.
/// Errors: a recording that does not allow a wrench analysis (no attitude, no rotor speed or command, wrong
/// number of rotors, less than two seconds of free flight), each with a next step.
Result<Flight> prepare_flight(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                              const Options& options);

}  // namespace omniflight::diagnosis
