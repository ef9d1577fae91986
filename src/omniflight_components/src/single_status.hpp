// diagnostic_msgs/DiagnosticArray with one status, so that ROS 2 tools show it.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "omniflight_bus/message.hpp"
#include "omniflight_msgs/types.hpp"

namespace omniflight::components {

/// Fills everything but the values. level: 0 OK, 1 WARN, 2 ERROR.
inline msgs::diagnostic_msgs::DiagnosticStatus& fill_single_status(msgs::diagnostic_msgs::DiagnosticArray& m,
                                                                   const bus::Time& stamp, std::uint8_t level,
                                                                   const std::string& name,
                                                                   const std::string& message) {
  m.header.stamp = stamp;
  bus::resize(m.status, 1);
  auto& status = bus::view(m.status)[0];
  status.level = level;
  bus::set_text(status.name, name);
  bus::set_text(status.message, message);
  bus::set_text(status.hardware_id, "");
  return status;
}

inline void fill_values(msgs::diagnostic_msgs::DiagnosticStatus& status,
                        std::initializer_list<std::pair<const char*, std::string>> given) {
  bus::resize(status.values, given.size());
  auto next = bus::view(status.values).begin();
  for (const auto& [key, value] : given) {
    bus::set_text(next->key, key);
    bus::set_text(next->value, value);
    ++next;
  }
}

}  // namespace omniflight::components
