// The newest rotor command, handed from the bus to whoever drives the plant.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <limits>
#include <mutex>
#include <optional>

#include "foreign_publisher.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::components {

struct RotorCommand {
  std::uint64_t number = 0;                         ///< commands that have come, this one included; 0: none
  std::int64_t stamp_ns = -1;                       ///< of the tick it answers
  std::array<double, vehicle::kMaxRotors> speed{};  ///< rad/s, signed
  std::size_t count = 0;
  double alpha = 0;  ///< rad
};

class CommandInbox {
 public:
  Status subscribe(const bus::Participant& participant) {
    using msgs::actuator_msgs::Actuators;
    auto made = bus::Subscription<Actuators>::create(
        participant, topics::command, bus::Qos::control().from_one_publisher(),
        [this](const Actuators& message, std::int64_t) {
          const auto speeds = bus::view(message.velocity);
          if (speeds.size() > vehicle::kMaxRotors) return;
          {
            const std::lock_guard lock(mutex_);
            const std::int64_t stamp_ns = bus::nanoseconds(message.header.stamp);
            if (stamp_ns > latest_ns_) {
              say_refused(stamp_ns);
              return;
            }
            ++newest_.number;
            newest_.stamp_ns = stamp_ns;
            newest_.count = speeds.size();
            std::copy(speeds.begin(), speeds.end(), newest_.speed.begin());
            newest_.alpha = message.position._length > 0 ? message.position._buffer[0] : 0.0;
          }
          arrived_.notify_one();
        },
        &say_foreign);
    if (!made) return Failure(made.error());
    subscription_.emplace(std::move(*made));
    return {};
  }
  void unsubscribe() { subscription_.reset(); }
  const bus::Subscription<msgs::actuator_msgs::Actuators>& subscription() const { return *subscription_; }

  /// From here on commands answer ticks up to this stamp; later ones answer none, are refused and said. Call
  /// it before the tick is published.
  void answer_up_to(std::int64_t tick_ns) {
    const std::lock_guard lock(mutex_);
    latest_ns_ = tick_ns;
  }

  /// The newest command, if there is one.
  RotorCommand newest() const {
    const std::lock_guard lock(mutex_);
    return newest_;
  }
  /// Waits for the command that answers the tick with this stamp; false after the timeout.
  bool wait_for(std::int64_t stamp_ns, std::chrono::nanoseconds timeout, RotorCommand& out) {
    std::unique_lock lock(mutex_);
    const bool arrived = arrived_.wait_for(lock, timeout, [&] { return newest_.stamp_ns >= stamp_ns; });
    out = newest_;
    return arrived;
  }

 private:
  void say_refused(std::int64_t stamp_ns) {
    constexpr std::uint64_t kEvery = 1000;
    if (refused_++ % kEvery == 0)
      std::fprintf(
          stderr, "[plant] a command stamped %.6g s ahead of the newest tick is refused (%llu so far)\n",
          1e-9 * static_cast<double>(stamp_ns - latest_ns_), static_cast<unsigned long long>(refused_));
  }

  mutable std::mutex mutex_;
  std::int64_t latest_ns_ = std::numeric_limits<std::int64_t>::max();
  std::uint64_t refused_ = 0;
  std::condition_variable arrived_;
  RotorCommand newest_;
  std::optional<bus::Subscription<msgs::actuator_msgs::Actuators>> subscription_;
};

}  // namespace omniflight::components
