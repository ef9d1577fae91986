// One recording made ready for analysis: filtered, on one time grid, with what was cut out and why.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_diagnosis/alignment_report.hpp"
#include "omniflight_diagnosis/options.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

struct Window {
  double from_s = 0, to_s = 0;
  std::string why;
};

struct ParameterValue {
  std::string name, symbol, unit;
  double value = 0, low = 0, high = 0;  ///< 95 % interval
};

/// A sensor that lies; found before anything is fitted.
struct SensorFault {
  std::string effect;   ///< contracts id
  std::string channel;  ///< "rotor1_speed", "vbat"
  std::string sentence;
  double share = 0;       ///< of the flight
  double log_factor = 0;  ///< ln Bayes factor against a sensor that works; where it has a size, that tells
  std::vector<ParameterValue> parameters = {};  ///< where it has a size
  std::vector<std::string> rivals = {};         ///< what this recording shows alike
};

/// Uninterrupted samples [begin, end) of the grid that may be used.
struct Segment {
  int begin = 0, end = 0;
};

/// Commands of rotor speeds as they were recorded.
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
  std::vector<std::string> notes;  ///< what a missing signal costs, in sentences

  double rate_hz = 0;  ///< of the grid
  double reach_s = 0;  ///< how far interpolation between samples of the slowest signal reads ahead
  /// Standard deviation [s] of the kernel, block mean included, under which signals reach a sample of the
  /// grid.
  double kernel_s = 0;
  std::vector<double> t;
  std::vector<physics::Situation> situation;  ///< state, rotors and accelerations at every grid time
  Eigen::MatrixXd specific_force;             ///< n x 3, m/s^2, body
  Eigen::MatrixXd rotor_speed;                ///< n x rotors, rad/s
  /// n x any number, body frame of the reference: what it asks of the rotors (specific force, angular
  /// acceleration) and its velocities, as far as it is recorded. No disturbance moves it.
  Eigen::MatrixXd reference;
  Eigen::MatrixXd tracking_error;  ///< n x 3, m, position minus reference; empty without reference
  std::vector<Segment> segments;
  bool has_accelerometer = false, has_gyro = false, has_alpha = false, has_position = false;
  bool speed_from_command = false;  ///< there are no measured rotor speeds
  CommandTrack commands;            ///< from which the speeds are computed where none are measured
  bool thrust_modelled = false;     ///< thrust comes from duty cycles, its scale from this flight
  Eigen::VectorXd log_drive,
      log_voltage;  ///< of a modelled thrust: ln of mean speed and voltage over their means
  std::vector<Alignment> alignment;
  double floor_z = 0;  ///< m, as used
  std::optional<double>
      stood_at;  ///< m, height of the body's frame while it stood; empty: floor told, or never

  int size() const { return static_cast<int>(t.size()); }
  int usable() const;
  bool has(const std::string& signal) const;
};

/// Copies, frozen and clipped samples are cut out and clocks put right first.
/// Errors: a recording that cannot carry a wrench analysis (no attitude, no rotor speed or command, wrong
/// number of rotors, less than two seconds of free flight), each with what would help.
Result<Flight> prepare_flight(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                              const Options& options);

}  // namespace omniflight::diagnosis
