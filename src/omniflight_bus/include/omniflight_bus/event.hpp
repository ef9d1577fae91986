// What the bus reports besides messages.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace omniflight::bus {

enum class EventKind {
  matched,             ///< a peer came or went; count = peers now
  deadline_missed,     ///< count = misses so far
  liveliness_changed,  ///< count = publishers alive now; for a publisher: its own lease ended, count = times
                       ///< so far
  incompatible_qos,    ///< a peer of this topic can never match; detail names the policy
  sample_lost,         ///< count = messages lost so far
  foreign_publisher,   ///< a message of another publisher was refused (Qos::one_publisher); count = so far
};

struct Event {
  EventKind kind;
  const std::string& topic;  ///< ROS name
  std::uint64_t count;
  const char* detail;  ///< "" or the name of the policy
};

/// Called on a thread of the middleware, or inside the peer's publish: be brief, never wait.
using EventCallback = std::function<void(const Event&)>;

}  // namespace omniflight::bus
