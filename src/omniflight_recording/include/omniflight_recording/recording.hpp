// What was flown, whoever logged it: named signals in SI units, each on its own time base, with provenance.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::recording {

/// One signal. Times are strictly increasing [s] on the recording's clock; every value is finite.
struct Signal {
  std::string name;         ///< canonical name, see canonical_signals()
  std::string unit;         ///< of every component
  std::vector<double> t_s;  ///< s
  Eigen::MatrixXd values;   ///< rows = samples, columns = components
  std::string source;       ///< topic, variable or column it came from

  Eigen::Index size() const { return values.rows(); }
  Eigen::Index width() const { return values.cols(); }
  bool empty() const { return t_s.empty(); }
  /// Median time between samples [s]; 0 with fewer than two samples.
  double median_period_s() const;
};

/// Something the reader wants to be known: a loss, a gap, an ignored column.
struct Note {
  enum class Kind { loss, damage, ignored, information };
  Kind kind = Kind::information;
  std::string text;
  std::uint64_t messages = 0;  ///< messages or records lost or ignored, 0 when unknown
  double from_s = 0.0;         ///< affected time on the recording's clock [s], 0 and 0 when unknown
  double to_s = 0.0;
};

/// One topic of a log and what became of it.
struct TopicSummary {
  std::string name;                ///< of a further instance with its number: "sensor_accel#1"
  std::string type;                ///< "sensor_msgs/Imu"; empty where the format has none
  std::uint64_t messages = 0;      ///< in the file
  std::vector<std::string> feeds;  ///< signals of the recording that were read from it
};

struct Recording {
  std::string file;      ///< path as given
  std::string format;    ///< name of the format, for instance "mcap"
  std::string sha256;    ///< of the file's bytes
  double start_s = 0.0;  ///< subtracted from the logger's clock to get t_s (an epoch time, else 0)
  double duration_s = 0.0;
  std::map<std::string, Signal> signals;
  std::map<std::string, std::string> metadata;
  std::map<std::string, double> parameters;  ///< of the autopilot when the log begins, by its own names
  std::vector<TopicSummary> topics;          ///< of formats that have topics, by name
  std::vector<Note> notes;

  /// The signal, or nullptr when it was not recorded or has no sample.
  const Signal* find(const std::string& name) const;
  /// The signal; the error names the file and lists what it does contain.
  Result<const Signal*> require(const std::string& name) const;
  std::vector<std::string> signal_names() const;
  bool lost_anything() const;  ///< some note tells of a loss or damage
  void note(Note::Kind kind, std::string text, std::uint64_t messages = 0, double from_s = 0,
            double to_s = 0);
};

/// Name, unit and width of a canonical signal (width 0 = one component a rotor).
struct SignalSpec {
  const char* name;
  const char* unit;
  int width;
};
const std::vector<SignalSpec>& canonical_signals();
const SignalSpec* find_spec(std::string_view name);
/// Signals whose four components are a unit quaternion (w, x, y, z), world <- body.
bool is_attitude(std::string_view name);

/// Values at the given times [s], linear between samples (slerp for attitudes). Rows are NaN before the first
/// and after the last sample and inside gaps longer than max_gap_s.
Eigen::MatrixXd resample(const Signal& signal, const std::vector<double>& t_s, double max_gap_s = 1e9);

/// The part of a signal with from_s <= t <= to_s.
Signal window(const Signal& signal, double from_s, double to_s);

/// Body angular velocity [rad/s] between consecutive samples of an attitude, at their midpoints.
Signal rate_of_attitude(const Signal& attitude);

}  // namespace omniflight::recording
