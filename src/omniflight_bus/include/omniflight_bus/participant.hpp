// One process's (or one component's) seat in a domain.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "omniflight_core/result.hpp"

namespace omniflight::bus {

/// Largest domain whose ports, with 100 processes, still fit below 65536.
inline constexpr int max_domain = 231;

namespace detail {
struct ParticipantState;
}

/// A handle that may be copied; the seat is given up when the last handle, publisher and subscription is
/// gone.
class Participant {
 public:
  /// domain in [0, max_domain]. Fails when no network interface or no free index is found.
  static Result<Participant> create(int domain);
  int domain() const;
  const std::shared_ptr<detail::ParticipantState>& state() const { return state_; }

 private:
  explicit Participant(std::shared_ptr<detail::ParticipantState> state) : state_(std::move(state)) {}
  std::shared_ptr<detail::ParticipantState> state_;
};

/// "/omni/pose" -> "rt/omni/pose", as ROS 2 does. Refuses names that ROS 2 would refuse.
Result<std::string> dds_topic_name(std::string_view ros_name);

}  // namespace omniflight::bus
