// Message definitions as a log carries them: the fields of a type and of the types it is made of.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::recording {

struct FieldDefinition {
  std::string type, name;
  bool array = false;
  std::uint32_t fixed = 0;  // length of a fixed array; 0 = sequence with a length in front
};

/// Fields of every type by its short name ("sensor_msgs/Imu"; in a ULog "vehicle_attitude").
using MessageTypes = std::map<std::string, std::vector<FieldDefinition>>;

/// "pkg/msg/Name" -> "pkg/Name".
std::string short_type(std::string name);

/// A ROS 1 or ROS 2 definition (.msg text, further types behind lines of '='). An error names `type`.
Result<MessageTypes> parse_ros_definition(const std::string& type, std::string_view text);

/// Adds the format message of a ULog: "name:float[3] x;other_type[2] y;". False when it is none.
bool add_ulog_format(std::string_view text, MessageTypes& types);

}  // namespace omniflight::recording
