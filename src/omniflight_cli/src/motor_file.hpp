// motor.json and gains.json, as identify-motor and tune-motor write them.
#pragma once

#include <string>
#include <vector>

#include "omniflight_identification/pidn.hpp"

namespace omniflight::cli {

/// A rotor of a motor.json.
struct MotorOfFile {
  int rotor = 0;                             ///< from 1
  identification::LagPlant up, down;         ///< while the speed rises and falls
  double low_radps = 0.0, high_radps = 0.0;  ///< between these it turned for four fifths of the time
  double noise_radps = 0.0;                  ///< rms, the smallest prediction error of its models
};

/// The rotors of a motor.json; `rotor` from 1, 0 for all. Errors name file and field.
Result<std::vector<MotorOfFile>> load_motors(const std::string& file, int rotor);

/// Both plants of every motor.
std::vector<identification::LagPlant> plants_of(const std::vector<MotorOfFile>& motors);

/// Gains of a gains.json.
Result<identification::PidnGains> load_gains(const std::string& file);

}  // namespace omniflight::cli
