#include "log_sources.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "omniflight_recording/vehicle_hints.hpp"

namespace omniflight::cli {

std::vector<std::string> topic_lines(const recording::Recording& r) {
  std::vector<std::string> out;
  std::vector<std::string> rest;
  for (const auto& t : r.topics) {
    const std::string type = t.type.empty() ? "" : " (" + t.type + ")";
    if (t.feeds.empty())
      rest.push_back(fmt::format("{} {}", t.name, t.messages));
    else
      out.push_back(
          fmt::format("topic {:36} {:8} messages{}: {}", t.name, t.messages, type, fmt::join(t.feeds, ", ")));
  }
  if (!rest.empty())
    out.push_back(
        fmt::format("{} topics feed no signal, with their messages: {}", rest.size(), fmt::join(rest, ", ")));
  return out;
}

nlohmann::json topics_json(const recording::Recording& r) {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& t : r.topics)
    out.push_back({{"name", t.name}, {"type", t.type}, {"messages", t.messages}, {"feeds", t.feeds}});
  return out;
}

std::vector<std::string> vehicle_lines(const recording::Recording& r) {
  const auto h = recording::vehicle_hints(r);
  std::vector<std::string> out;
  if (!h.autopilot.empty()) out.push_back("autopilot: " + h.autopilot);
  if (h.rotor_count > 0)
    out.push_back(fmt::format("{} rotors{}{}", h.rotor_count, h.airframe.empty() ? "" : ", " + h.airframe,
                              h.rotors.empty() ? "; where they are is not told" : ""));
  for (std::size_t i = 0; i < h.rotors.size(); ++i) {
    const auto& rotor = h.rotors[i];
    out.push_back(
        fmt::format("rotor {}: at ({:.3f}, {:.3f}, {:.3f}) m, axis ({:.2f}, {:.2f}, {:.2f}), spin {:+}, drag "
                    "ratio {:.3f} m",
                    i + 1, rotor.p_B.x(), rotor.p_B.y(), rotor.p_B.z(), rotor.axis_B.x(), rotor.axis_B.y(),
                    rotor.axis_B.z(), rotor.spin, rotor.drag_ratio));
  }
  if (h.mass) out.push_back(fmt::format("mass {:.3f} kg", *h.mass));
  if (h.hover_duty) out.push_back(fmt::format("hovers at duty {:.2f} by its own parameter", *h.hover_duty));
  if (h.battery_cells) out.push_back(fmt::format("battery of {} cells", *h.battery_cells));
  return out;
}

nlohmann::json vehicle_json(const recording::Recording& r) {
  const auto h = recording::vehicle_hints(r);
  nlohmann::json rotors = nlohmann::json::array();
  for (const auto& rotor : h.rotors)
    rotors.push_back({{"position_m", {rotor.p_B.x(), rotor.p_B.y(), rotor.p_B.z()}},
                      {"axis", {rotor.axis_B.x(), rotor.axis_B.y(), rotor.axis_B.z()}},
                      {"spin", rotor.spin},
                      {"drag_ratio_m", rotor.drag_ratio}});
  nlohmann::json out{{"autopilot", h.autopilot},
                     {"airframe", h.airframe},
                     {"rotor_count", h.rotor_count},
                     {"rotors", rotors}};
  if (h.mass) out["mass_kg"] = *h.mass;
  if (h.hover_duty) out["hover_duty"] = *h.hover_duty;
  if (h.battery_cells) out["battery_cells"] = *h.battery_cells;
  return out;
}

}  // namespace omniflight::cli
