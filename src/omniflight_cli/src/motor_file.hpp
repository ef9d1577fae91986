// motor.json and gains.json, as identify-motor and tune-motor write them.
#pragma once

#include <string>
#include <vector>

#include "omniflight_identification/pidn.hpp"

namespace omniflight::cli {

/// The motors of a motor.json: one plant for the lag up and one for the lag down of every rotor. `rotor` from
/// 1, 0 for all. Errors name file and field.
Result<std::vector<identification::LagPlant>> load_plants(const std::string& file, int rotor);

/// Gains of a gains.json.
Result<identification::PidnGains> load_gains(const std::string& file);

}  // namespace omniflight::cli
