// The failsafe ladder on the bus: diagnostic_msgs/DiagnosticArray with one status, so that ROS 2 tools show
// it, and the operator's wish as std_msgs/String.
#pragma once

#include <algorithm>

#include "omniflight_safety/vitals.hpp"
#include "single_status.hpp"

namespace omniflight::components {

/// status[0]: level OK (fly), WARN (hold, or poses refused) or ERROR; message "descend: pose_lost"; values
/// action (the number of safety::Action), landing (where a descent ends), refused (what was refused last),
/// refused_poses (count).
inline void fill_failsafe(msgs::diagnostic_msgs::DiagnosticArray& m, const bus::Time& stamp,
                          safety::Action action, const std::string& words, const std::string& landing,
                          const std::string& refused, std::uint64_t count) {
  const auto rank = static_cast<std::uint8_t>(action);
  auto& status = fill_single_status(
      m, stamp,
      action == safety::Action::fly ? (refused.empty() ? 0 : 1) : (action == safety::Action::hold ? 1 : 2),
      "omniflight: failsafe", words);
  fill_values(status, {{"action", std::to_string(rank)},
                       {"landing", landing},
                       {"refused", refused},
                       {"refused_poses", std::to_string(count)}});
}

/// The action in such a message; nothing when it is none of ours.
inline std::optional<safety::Action> failsafe_action(const msgs::diagnostic_msgs::DiagnosticArray& m) {
  const auto statuses = bus::view(m.status);
  if (statuses.empty()) return {};
  const auto values = bus::view(statuses[0].values);
  if (values.empty() || bus::text(values[0].key) != "action") return {};
  const std::string_view text = bus::text(values[0].value);
  if (text.size() != 1 || text[0] < '0' || text[0] >= static_cast<char>('0' + safety::kActions)) return {};
  return static_cast<safety::Action>(text[0] - '0');
}

/// The operator's wish that the ladder obeys in such a message: whoever hears of it from the ladder first
/// knows it as the operator's, and not as a failure.
inline safety::Wish wish_of_ladder(const msgs::diagnostic_msgs::DiagnosticArray& m) {
  const auto statuses = bus::view(m.status);
  const std::string_view words = statuses.empty() ? std::string_view() : bus::text(statuses[0].message);
  if (words.ends_with(to_string(safety::Fault::emergency_stop))) return safety::Wish::cut;
  if (words.ends_with(to_string(safety::Fault::operator_stop))) return safety::Wish::stop;
  return safety::Wish::none;
}

/// hold | land | stop | cut; anything else is no wish.
inline safety::Wish wish_from(std::string_view text) {
  if (text == "hold") return safety::Wish::hold;
  if (text == "land") return safety::Wish::land;
  if (text == "stop") return safety::Wish::stop;
  if (text == "cut") return safety::Wish::cut;
  return safety::Wish::none;
}

/// What holds once `said` is heard. A stop is never taken back: another wish may come before the control loop
/// has looked, in the same period or after a pause of the machine, and would take its place.
inline safety::Wish heard_after(safety::Wish before, safety::Wish said) {
  return before >= safety::Wish::stop ? std::max(before, said) : said;
}

}  // namespace omniflight::components
