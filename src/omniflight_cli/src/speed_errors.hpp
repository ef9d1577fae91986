// How well rotors followed their commands, and the list of runs in which that is kept.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_identification/pidn.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

/// |commanded - measured speed| [rad/s] while the rotor is commanded to turn.
struct SpeedErrors {
  std::vector<double> mean, max;  ///< one a rotor
  double overall() const;         ///< mean of the means
};

/// Errors: no rotor_command or rotor_speed, or a rotor that is never commanded to turn.
Result<SpeedErrors> speed_errors(const recording::Recording& recording);

/// Now, as runs.csv has it: UTC, "2026-11-24T20:15:00Z".
std::string now_utc();

/// One line of runs.csv. Times are UTC, "2026-11-24T20:15:00Z".
struct RunRow {
  std::string time, log;
  identification::PidnGains gains;  ///< NaN where they are not known
  SpeedErrors errors;
};

/// time, log, kp, ki, kd, n, better, mean_error_radps, then rotorI_mean_radps and rotorI_max_radps of each
/// rotor. Reading refuses other columns, lines that do not fit and numbers that are none, naming file and
/// line. An absent file is an empty list.
Result<std::vector<RunRow>> read_runs(const std::string& file);
/// Whole or not at all. A row is better when its mean error is below that of all rows before it.
Status write_runs(const std::string& file, const std::vector<RunRow>& rows);
/// Index of the row with the smallest mean error.
std::optional<std::size_t> best_run(const std::vector<RunRow>& rows);

}  // namespace omniflight::cli
