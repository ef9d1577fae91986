// How many messages never arrived: what the publishers say they sent, against what was received.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "omniflight_msgs/types.hpp"

namespace omniflight::bus {

/// Feed it every message of /component_state. While components run the counts are up to a second old or a
/// message ahead; after they are deactivated they are exact. A component that starts again counts from 0
/// again, which is allowed for. Safe from any thread.
class DeliveryLedger {
 public:
  void note(const msgs::omniflight_msgs::ComponentState& state);
  /// Messages sent on the topic by all components that were heard of.
  std::uint64_t sent(std::string_view topic) const;
  /// Of those, how many are missing when this many were received; 0 when none or when the count is behind.
  std::uint64_t lost(std::string_view topic, std::uint64_t received) const;

 private:
  struct Count {
    std::uint64_t earlier = 0;  ///< sent before it was started again
    std::uint64_t now = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, std::string>, Count> counts_;  ///< by topic and component
};

}  // namespace omniflight::bus
