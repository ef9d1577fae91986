// A mission that is asked for in flight, and the planner's answer: diagnostic_msgs/DiagnosticArray with one
// status, so that ROS 2 tools show it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "omniflight_msgs/types.hpp"

namespace omniflight::components {

/// Beside a plan that was made in flight: the time [s] of the flown trajectory at which it begins.
inline constexpr const char* kJoinFile = "join_s";

/// What topics::mission carries: the mission in the first line and, where the asker wants to recognise the
/// answer, a word of its own in the second.
struct MissionRequest {
  std::string mission;  ///< name under configs/missions, or an absolute path
  std::string id;       ///< may be empty

  std::string text() const { return id.empty() ? mission : mission + "\n" + id; }
  static MissionRequest of(std::string_view text);
};

enum class Replanning { planning, joined, kept };

/// The planner's answer to a request.
struct ReplanningAnswer {
  MissionRequest request;
  Replanning state = Replanning::planning;
  std::string words;  ///< why the old plan is kept, or from when on the new one is flown
};

/// level: 0 planning and joined, 1 kept; message: words; values: mission, request, state.
void to_message(const ReplanningAnswer& answer, msgs::diagnostic_msgs::DiagnosticArray& out);
/// Nothing when the message is none of these.
std::optional<ReplanningAnswer> replanning_answer(const msgs::diagnostic_msgs::DiagnosticArray& message);

}  // namespace omniflight::components
