// Rotors that the allocator leaves out, on the bus: diagnostic_msgs/DiagnosticArray with one status, so that
// ROS 2 tools show it.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "single_status.hpp"

namespace omniflight::components {

/// status[0]: level WARN while the others can hover, else ERROR; message in words; values lost_rotors (bits,
/// bit 0 is rotor 1) and hover_load (share of their range that the others need to hover, "inf" where they
/// cannot).
inline void fill_lost_rotors(msgs::diagnostic_msgs::DiagnosticArray& m, const bus::Time& stamp,
                             std::uint32_t lost, double hover_load, const std::string& words) {
  auto& status = fill_single_status(m, stamp, hover_load <= 1.0 ? 1 : 2, "omniflight: lost rotors", words);
  fill_values(status, {{"lost_rotors", std::to_string(lost)},
                       {"hover_load", std::isfinite(hover_load) ? std::to_string(hover_load) : "inf"}});
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
