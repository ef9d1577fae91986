// The estimated pose in the transform tree of ROS 2 (tf2): /tf from map, the world, to base_link, the body.
// Frames as REP 103 and REP 105 name them; the other messages of a flight carry the same names.
#pragma once

#include <cmath>
#include <optional>

#include "conversions.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/publisher.hpp"

namespace omniflight::components {

/// Transforms a second of flight time; 0: none.
inline double read_transform_rate(bus::Parameters& p) { return p.number("transform_hz", 50.0, 0, 1000); }

/// Publishing allocates nothing.
class TransformPublisher {
 public:
  explicit TransformPublisher(double rate_hz) : period_ns_(rate_hz > 0 ? std::llround(1e9 / rate_hz) : 0) {
    bus::resize(message_->transforms, 1);
    auto& transform = bus::view(message_->transforms)[0];
    bus::set_text(transform.header.frame_id, "map");
    bus::set_text(transform.child_frame_id, "base_link");
  }
  bool wanted() const { return period_ns_ > 0; }
  void attach(bus::Publisher<msgs::tf2_msgs::TFMessage> publisher) { publisher_ = std::move(publisher); }

  /// p_WB [m] and q_WB at the stamp, unless the last one is less than a period old.
  Status publish(const bus::Time& stamp, const Vec3& p_WB, const Quat& q_WB) {
    const std::int64_t ns = bus::nanoseconds(stamp);
    const bool early = ns < due_ns_ && ns >= due_ns_ - period_ns_;
    if (!publisher_ || early) return {};
    due_ns_ = ns + period_ns_;
    auto& transform = bus::view(message_->transforms)[0];
    transform.header.stamp = stamp;
    put(transform.transform.translation, p_WB);
    put_quaternion(transform.transform.rotation, q_WB);
    return publisher_->publish(*message_, ns);
  }

 private:
  std::int64_t period_ns_, due_ns_ = 0;
  bus::Message<msgs::tf2_msgs::TFMessage> message_;
  std::optional<bus::Publisher<msgs::tf2_msgs::TFMessage>> publisher_;
};

}  // namespace omniflight::components
