// Sending messages of one type on one topic.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>

#include "omniflight_bus/event.hpp"
#include "omniflight_bus/message.hpp"
#include "omniflight_bus/participant.hpp"
#include "omniflight_bus/qos.hpp"

namespace omniflight::bus {

/// How many messages were sent on a topic; outlives the publisher so that the last report can still tell it.
struct SentCount {
  std::string topic;
  std::atomic<std::uint64_t> sent{0};
};

namespace detail {
struct Writer;

/// The part of a publisher that does not depend on the type.
class PublisherBase {
 public:
  PublisherBase(PublisherBase&&) noexcept;
  PublisherBase& operator=(PublisherBase&&) noexcept;
  ~PublisherBase();

  /// Waits until n subscriptions are matched; fails with ErrorCode::incomplete after the timeout. A
  /// subscription in another process may know of this publisher a few milliseconds later than the other way
  /// round.
  Status wait_for_peers(std::uint32_t n, std::chrono::nanoseconds timeout) const;
  /// Waits until every reliable subscription has acknowledged everything sent.
  Status wait_for_acknowledgement(std::chrono::nanoseconds timeout) const;
  std::uint32_t peers() const;
  const std::string& topic() const;
  std::uint64_t sent() const { return count_->sent.load(std::memory_order_relaxed); }
  std::shared_ptr<const SentCount> sent_count() const { return count_; }

 protected:
  static Result<PublisherBase> create(const Participant& participant, const msgs::MessageType& type,
                                      std::string_view topic, const Qos& qos, EventCallback on_event);
  Status publish_sample(const void* sample, std::int64_t source_ns);

 private:
  PublisherBase(std::unique_ptr<Writer> writer, std::shared_ptr<SentCount> count);
  std::unique_ptr<Writer> writer_;
  std::shared_ptr<SentCount> count_;
};

}  // namespace detail

/// Nanoseconds since 1970 of the system clock, as the bus stamps messages without a stamp of their own.
std::int64_t wall_clock_ns();

/// Publishing runs the callbacks of subscriptions in this process before it returns. So a callback must not
/// publish on its own topic (refused with an Error), nor may two callbacks on two threads publish on each
/// other's topic.
template <class T>
class Publisher : public detail::PublisherBase {
 public:
  static Result<Publisher> create(const Participant& participant, std::string_view topic, const Qos& qos = {},
                                  EventCallback on_event = {}) {
    auto base =
        PublisherBase::create(participant, msgs::TypeSupport<T>::type(), topic, qos, std::move(on_event));
    if (!base) return Failure(std::move(base.error()));
    return Publisher(std::move(*base));
  }
  /// source_ns: instant the message is about [ns], >= 0, travels beside it as source timestamp.
  Status publish(const T& message, std::int64_t source_ns) { return publish_sample(&message, source_ns); }
  Status publish(const T& message) { return publish_sample(&message, wall_clock_ns()); }

 private:
  explicit Publisher(PublisherBase&& base) : PublisherBase(std::move(base)) {}
};

}  // namespace omniflight::bus
