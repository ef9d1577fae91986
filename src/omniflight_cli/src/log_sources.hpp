// What `info` and `diagnose --check` say of the log itself: its topics, and the vehicle that wrote it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

/// A line for each topic that feeds a signal, and one with the rest. Empty for formats without topics.
std::vector<std::string> topic_lines(const recording::Recording& recording);
nlohmann::json topics_json(const recording::Recording& recording);

/// What the log tells of its vehicle, a line each; empty when it tells nothing.
std::vector<std::string> vehicle_lines(const recording::Recording& recording);
nlohmann::json vehicle_json(const recording::Recording& recording);

}  // namespace omniflight::cli
