#include "omniflight_components/replanning_message.hpp"

#include "single_status.hpp"

namespace omniflight::components {
namespace {

constexpr const char* kStates[] = {"planning", "joined", "kept"};

}  // namespace

MissionRequest MissionRequest::of(std::string_view text) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) return {std::string(text), ""};
  return {std::string(text.substr(0, end)), std::string(text.substr(end + 1))};
}

void to_message(const ReplanningAnswer& answer, msgs::diagnostic_msgs::DiagnosticArray& out) {
  auto& status = fill_single_status(out, {}, answer.state == Replanning::kept ? 1 : 0,
                                    "omniflight: replanning", answer.words);
  fill_values(status, {{"mission", answer.request.mission},
                       {"request", answer.request.id},
                       {"state", kStates[static_cast<int>(answer.state)]}});
}

std::optional<ReplanningAnswer> replanning_answer(const msgs::diagnostic_msgs::DiagnosticArray& message) {
  const auto statuses = bus::view(message.status);
  if (statuses.empty()) return {};
  const auto values = bus::view(statuses[0].values);
  if (values.size() < 3 || bus::text(values[0].key) != "mission" || bus::text(values[1].key) != "request" ||
      bus::text(values[2].key) != "state")
    return {};
  ReplanningAnswer out;
  out.request = {std::string(bus::text(values[0].value)), std::string(bus::text(values[1].value))};
  out.words = bus::text(statuses[0].message);
  for (int k = 0; k < 3; ++k)
    if (bus::text(values[2].value) == kStates[k]) {
      out.state = static_cast<Replanning>(k);
      return out;
    }
  return {};
}

}  // namespace omniflight::components
