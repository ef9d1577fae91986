// Rotors that the allocator leaves out, on the bus: diagnostic_msgs/DiagnosticArray with one status, so that
// ROS 2 tools show it.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "omniflight_bus/message.hpp"
#include "omniflight_msgs/types.hpp"

namespace omniflight::components {

/// status[0]: level WARN while the others can hover, else ERROR; message in words; values lost_rotors (bits,
/// bit 0 is rotor 1) and hover_load (share of their range that the others need to hover, "inf" where they
/// cannot).
inline void fill_lost_rotors(msgs::diagnostic_msgs::DiagnosticArray& m, const bus::Time& stamp,
                             std::uint32_t lost, double hover_load, const std::string& words) {
  m.header.stamp = stamp;
  bus::resize(m.status, 1);
  auto& status = bus::view(m.status)[0];
  status.level = hover_load <= 1.0 ? 1 : 2;
  bus::set_text(status.name, "omniflight: lost rotors");
  bus::set_text(status.message, words);
  bus::set_text(status.hardware_id, "");
  bus::resize(status.values, 2);
  auto values = bus::view(status.values);
  bus::set_text(values[0].key, "lost_rotors");
  bus::set_text(values[0].value, std::to_string(lost));
  bus::set_text(values[1].key, "hover_load");
  bus::set_text(values[1].value, std::isfinite(hover_load) ? std::to_string(hover_load) : "inf");
}

/// The hover load in such a message; nothing when it is none of ours.
inline std::optional<double> hover_load_in(const msgs::diagnostic_msgs::DiagnosticArray& m) {
  const auto statuses = bus::view(m.status);
  if (statuses.empty()) return {};
  const auto values = bus::view(statuses[0].values);
  if (values.size() < 2 || bus::text(values[1].key) != "hover_load") return {};
  const std::string_view text = bus::text(values[1].value);
  double load = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), load);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || !(load >= 0)) return {};
  return load;
}

}  // namespace omniflight::components
