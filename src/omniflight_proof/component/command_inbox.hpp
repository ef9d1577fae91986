// The newest rotor command, handed from the bus to the thread that steps the plant.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "omniflight_bus/subscription.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "topics.hpp"

namespace omniflight::proof {

class CommandInbox {
 public:
  struct Command {
    std::int64_t stamp_ns = -1;                       ///< of the tick it answers; < 0: none yet
    std::array<double, vehicle::kMaxRotors> speed{};  ///< rad/s
    std::size_t count = 0;
    double alpha = 0;  ///< rad
  };

  Status subscribe(const bus::Participant& participant) {
    using msgs::actuator_msgs::Actuators;
    auto made = bus::Subscription<Actuators>::create(
        participant, topics::command, bus::Qos::control(), [this](const Actuators& message, std::int64_t) {
          const auto speeds = bus::view(message.velocity);
          if (speeds.size() > vehicle::kMaxRotors) return;
          {
            const std::lock_guard lock(mutex_);
            newest_.stamp_ns = bus::nanoseconds(message.header.stamp);
            newest_.count = speeds.size();
            std::copy(speeds.begin(), speeds.end(), newest_.speed.begin());
            newest_.alpha = message.position._length > 0 ? message.position._buffer[0] : 0.0;
          }
          arrived_.notify_one();
        });
    if (!made) return Failure(made.error());
    subscription_.emplace(std::move(*made));
    return {};
  }
  void unsubscribe() { subscription_.reset(); }
  std::uint32_t peers() const { return subscription_->peers(); }

  Command newest() const {
    const std::lock_guard lock(mutex_);
    return newest_;
  }
  /// False when no answer to the tick of this stamp came in time; out is the newest command either way.
  bool wait_for(std::int64_t stamp_ns, std::chrono::nanoseconds timeout, Command& out) {
    std::unique_lock lock(mutex_);
    const bool arrived = arrived_.wait_for(lock, timeout, [&] { return newest_.stamp_ns == stamp_ns; });
    out = newest_;
    return arrived;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  Command newest_;
  std::optional<bus::Subscription<msgs::actuator_msgs::Actuators>> subscription_;
};

}  // namespace omniflight::proof
