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
struct RosNode;
}  // namespace detail

/// A handle that may be copied; the seat is given up when the last handle, publisher and subscription is
/// gone.
class Participant {
 public:
  /// domain in [0, max_domain]. Fails when no network interface or no free index is found.
  static Result<Participant> create(int domain);
  int domain() const;
  /// The same seat; publishers and subscriptions that are created with this handle belong to a node of ROS 2
  /// with this name, as `ros2 node list` shows it, until the last of them and of its handles is gone. Those
  /// of other handles belong to no node. ErrorCode::bad_input when ROS 2 would refuse the name.
  Result<Participant> as_node(const std::string& name) const;
  const std::shared_ptr<detail::ParticipantState>& state() const { return state_; }
  const std::shared_ptr<detail::RosNode>& node() const { return node_; }

 private:
  explicit Participant(std::shared_ptr<detail::ParticipantState> state) : state_(std::move(state)) {}
  std::shared_ptr<detail::ParticipantState> state_;
  std::shared_ptr<detail::RosNode> node_;  ///< null: none
};

/// "/omni/pose" -> "rt/omni/pose", as ROS 2 does. Refuses names that ROS 2 would refuse.
Result<std::string> dds_topic_name(std::string_view ros_name);

}  // namespace omniflight::bus
