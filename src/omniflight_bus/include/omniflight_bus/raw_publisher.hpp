// Sending bytes that are CDR already, for replaying a recording.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "omniflight_bus/event.hpp"
#include "omniflight_bus/participant.hpp"
#include "omniflight_bus/qos.hpp"
#include "omniflight_msgs/message_type.hpp"

namespace omniflight::bus {

class RawPublisher {
 public:
  static Result<RawPublisher> create(const Participant& participant, const msgs::MessageType& type,
                                     std::string_view topic, const Qos& qos = {},
                                     EventCallback on_event = {});
  RawPublisher(RawPublisher&&) noexcept;
  RawPublisher& operator=(RawPublisher&&) noexcept;
  ~RawPublisher();

  /// cdr: XCDR1 with its 4-byte encapsulation header, either byte order. ErrorCode::bad_input when the bytes
  /// are no message of the type. source_ns as in Publisher::publish.
  Status publish(std::span<const std::byte> cdr, std::int64_t source_ns);
  Status wait_for_peers(std::uint32_t n, std::chrono::nanoseconds timeout) const;

 private:
  struct State;
  explicit RawPublisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace omniflight::bus
