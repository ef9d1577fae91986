// Tilts and rotors as joints of ROS 2: /joint_states as commanded, and /robot_description, whose joints they
// are. Link names as REP 105 has them; base_link is the body, which /tf places in the map.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "conversions.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_vehicle/robot_description.hpp"

namespace omniflight::components {

/// Publishing allocates nothing.
class JointPublisher {
 public:
  /// Messages a second of flight time.
  JointPublisher(const vehicle::Vehicle& vehicle, double rate_hz)
      : period_ns_(std::llround(1e9 / rate_hz)), rotors_(vehicle.rotors.size()) {
    const auto names = vehicle::joint_names(vehicle);
    bus::resize(message_->name, names.size());
    for (std::size_t i = 0; i < names.size(); ++i) bus::set_text(bus::view(message_->name)[i], names[i]);
    bus::resize(message_->position, names.size());
    bus::resize(message_->velocity, names.size());
    bus::set_text(description_->data, vehicle::robot_description(vehicle));
  }

  /// The description goes out at once, for whoever comes later.
  Status attach(bus::Publisher<msgs::sensor_msgs::JointState> states,
                bus::Publisher<msgs::std_msgs::String> description) {
    states_ = std::move(states);
    latched_ = std::move(description);
    return latched_->publish(*description_);
  }

  /// Speeds [rad/s] and tilt [rad] at the stamp, unless the last one is less than a period old. Angles of
  /// rotors are those that the speeds add up to.
  Status publish(const bus::Time& stamp, std::span<const double> speed, double alpha) {
    const std::int64_t ns = bus::nanoseconds(stamp);
    const bool early = ns < due_ns_ && ns >= due_ns_ - period_ns_;
    if (!states_ || early) return {};
    const double passed = 1e-9 * static_cast<double>(std::clamp<std::int64_t>(ns - last_ns_, 0, period_ns_));
    last_ns_ = ns;
    due_ns_ = ns + period_ns_;
    const auto position = bus::view(message_->position), velocity = bus::view(message_->velocity);
    for (std::size_t i = 0; i < position.size(); ++i) {
      const bool is_rotor = i < rotors_;
      velocity[i] = is_rotor && i < speed.size() ? speed[i] : 0.0;
      position[i] = is_rotor ? std::remainder(position[i] + passed * velocity[i], 2.0 * kPi) : alpha;
    }
    message_->header.stamp = stamp;
    return states_->publish(*message_, ns);
  }

 private:
  std::int64_t period_ns_, due_ns_ = 0, last_ns_ = 0;
  std::size_t rotors_;
  bus::Message<msgs::sensor_msgs::JointState> message_;
  bus::Message<msgs::std_msgs::String> description_;
  std::optional<bus::Publisher<msgs::sensor_msgs::JointState>> states_;
  std::optional<bus::Publisher<msgs::std_msgs::String>> latched_;
};

}  // namespace omniflight::components
