// Quality of service as profiles. There is no KEEP_ALL: a reader that hangs would then block its writer.
#pragma once

#include <cstdint>
#include <optional>

namespace omniflight::bus {

struct Qos {
  bool reliable = true;     ///< lost packets are sent again, as long as they are among the last `depth`
  bool latched = false;     ///< late subscribers receive the last `depth` messages (TRANSIENT_LOCAL)
  std::int32_t depth = 10;  ///< messages kept by each side (KEEP_LAST)
  /// Longest time between two messages [ns]. A subscription that asks for one only matches publishers that
  /// offer the same or a shorter one; on_event reports each miss.
  std::optional<std::int64_t> deadline_ns;
  /// Lease [ns] that each publish renews; its end is reported as liveliness_changed (MANUAL_BY_TOPIC). Both
  /// sides.
  std::optional<std::int64_t> liveliness_lease_ns;
  /// Subscription: follows one publisher, the first that it hears, as long as that lives and is not silent
  /// for a second. Messages of others are refused, counted (Subscription::foreign) and reported as
  /// foreign_publisher. Not DDS's EXCLUSIVE ownership: any stranger with a higher strength would win there.
  bool one_publisher = false;

  /// ROS 2 default: reliable, volatile, last 10.
  static Qos standard() { return {}; }
  /// Best effort, last 5.
  static Qos sensor_data() {
    return {.reliable = false,
            .latched = false,
            .depth = 5,
            .deadline_ns = {},
            .liveliness_lease_ns = {},
            .one_publisher = false};
  }
  /// Control path: reliable, short history, never blocks the writer on a reader that hangs.
  static Qos control(std::int32_t depth = 8) {
    return {.reliable = true,
            .latched = false,
            .depth = depth,
            .deadline_ns = {},
            .liveliness_lease_ns = {},
            .one_publisher = false};
  }
  /// The last message for whoever comes later. A subscription gives the number of publishers as its depth.
  static Qos latched_last(std::int32_t depth = 1) {
    return {.reliable = true,
            .latched = true,
            .depth = depth,
            .deadline_ns = {},
            .liveliness_lease_ns = {},
            .one_publisher = false};
  }
  /// The same profile, from one publisher alone.
  Qos from_one_publisher() const {
    Qos out = *this;
    out.one_publisher = true;
    return out;
  }
  /// Many messages between two looks: recorders and logs.
  static Qos bulk(std::int32_t depth = 4096) {
    return {.reliable = true,
            .latched = false,
            .depth = depth,
            .deadline_ns = {},
            .liveliness_lease_ns = {},
            .one_publisher = false};
  }
};

}  // namespace omniflight::bus
