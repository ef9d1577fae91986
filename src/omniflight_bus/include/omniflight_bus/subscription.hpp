// Receiving messages of one type on one topic: by callback, or by taking them with a timeout.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "omniflight_bus/event.hpp"
#include "omniflight_bus/message.hpp"
#include "omniflight_bus/participant.hpp"
#include "omniflight_bus/qos.hpp"

namespace omniflight::bus {
namespace detail {
struct Reader;
using SampleCallback = std::function<void(const void* sample, std::int64_t source_ns)>;
using BytesCallback = std::function<void(std::span<const std::byte> cdr, std::int64_t source_ns)>;

/// The part of a subscription that does not depend on the type. After its destructor returns nothing is
/// called; it must not be destroyed inside its own callback.
class SubscriptionBase {
 public:
  SubscriptionBase(SubscriptionBase&&) noexcept;
  SubscriptionBase& operator=(SubscriptionBase&&) noexcept;
  ~SubscriptionBase();

  /// Waits until n publishers are matched; fails with ErrorCode::incomplete after the timeout.
  Status wait_for_peers(std::uint32_t n, std::chrono::nanoseconds timeout) const;
  std::uint32_t peers() const;
  const std::string& topic() const;
  std::uint64_t received() const;  ///< messages delivered
  /// Losses that the middleware itself reports. It is silent about messages a publisher's history has dropped
  /// before this side was ready for them: DeliveryLedger counts all.
  std::uint64_t lost() const;
  /// Messages refused because another publisher is followed (Qos::one_publisher).
  std::uint64_t foreign() const;

 protected:
  static Result<SubscriptionBase> create(const Participant& participant, const msgs::MessageType& type,
                                         std::string_view topic, const Qos& qos, SampleCallback on_sample,
                                         BytesCallback on_bytes, EventCallback on_event);
  Result<bool> take_sample(void* sample, std::int64_t& source_ns, std::chrono::nanoseconds timeout);

 private:
  explicit SubscriptionBase(std::unique_ptr<Reader> reader);
  std::unique_ptr<Reader> reader_;
};

}  // namespace detail

template <class T>
class Subscription : public detail::SubscriptionBase {
 public:
  /// Called for every message, in the order received: inside publish for publishers of this process, on a
  /// thread of the middleware otherwise. One call at a time. The message is valid during the call only. Be
  /// brief, never wait.
  using Callback = std::function<void(const T& message, std::int64_t source_ns)>;

  static Result<Subscription> create(const Participant& participant, std::string_view topic, const Qos& qos,
                                     Callback callback, EventCallback on_event = {}) {
    return wrap(SubscriptionBase::create(
        participant, msgs::TypeSupport<T>::type(), topic, qos,
        [call = std::move(callback)](const void* sample, std::int64_t ns) {
          call(*static_cast<const T*>(sample), ns);
        },
        {}, std::move(on_event)));
  }
  /// Without a callback: messages wait, the last `qos.depth` of them, until they are taken.
  static Result<Subscription> create(const Participant& participant, std::string_view topic,
                                     const Qos& qos = {}) {
    return wrap(SubscriptionBase::create(participant, msgs::TypeSupport<T>::type(), topic, qos, {}, {}, {}));
  }

  /// Takes the oldest message; false when none came within the timeout [0 looks and returns]. Only without a
  /// callback.
  Result<bool> take(Message<T>& message, std::int64_t& source_ns, std::chrono::nanoseconds timeout) {
    return take_sample(&*message, source_ns, timeout);
  }

 private:
  explicit Subscription(SubscriptionBase&& base) : SubscriptionBase(std::move(base)) {}
  static Result<Subscription> wrap(Result<SubscriptionBase>&& base) {
    if (!base) return Failure(std::move(base.error()));
    return Subscription(std::move(*base));
  }
};

/// Receives the bytes of any type of the table: CDR with its 4-byte encapsulation header, as MCAP stores it,
/// without passing through the C struct. The bytes are valid during the call only.
class RawSubscription : public detail::SubscriptionBase {
 public:
  using Callback = detail::BytesCallback;
  static Result<RawSubscription> create(const Participant& participant, const msgs::MessageType& type,
                                        std::string_view topic, const Qos& qos, Callback callback,
                                        EventCallback on_event = {});

 private:
  explicit RawSubscription(SubscriptionBase&& base) : SubscriptionBase(std::move(base)) {}
};

}  // namespace omniflight::bus
