// What identify-motor found, as JSON, lines and a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "motor_data.hpp"
#include "omniflight_identification/identify_rotor.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {

struct RotorReport {
  Eigen::Index rotor = 0;  ///< from 0
  VoltageUse voltage = VoltageUse::none;
  identification::RotorResult result;
  identification::Dataset validation;
};

struct MotorReport {
  std::vector<std::string> recordings, sha256, held_out;
  MotorSignals signals;
  std::vector<RotorReport> rotors;
  std::vector<std::pair<Eigen::Index, Error>> failed;  ///< rotors that could not be identified
};

nlohmann::json to_json(const MotorReport& report);
std::string to_text(const MotorReport& report);
report::Page page_of(const MotorReport& report);

}  // namespace omniflight::cli
