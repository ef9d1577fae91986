#include "foxglove_relay.hpp"

#include <chrono>

#include "omniflight_bus/publisher.hpp"
#include "omniflight_components/topics.hpp"

namespace omniflight::cli {
namespace {

namespace topics = components::topics;

constexpr std::size_t kTopics = std::size(topics::recorded);
enum Extra : std::size_t { transform = kTopics, vehicle_entity, world_entity, plan_entity };

}  // namespace

std::shared_ptr<view::FoxgloveEndpoint> foxglove_endpoint() {
  std::vector<view::FoxgloveChannel> channels;
  for (const auto& entry : topics::recorded) {
    const msgs::MessageType* type = msgs::find_message_type(entry.type);
    channels.push_back({entry.topic, "cdr", entry.type, type ? std::string(type->schema) : std::string(),
                        "ros2msg", entry.latched});
  }
  channels.push_back(view::transform_channel());
  channels.push_back(view::vehicle_channel());
  channels.push_back(view::world_channel());
  channels.push_back(view::plan_channel());
  return std::make_shared<view::FoxgloveEndpoint>("omniflight", std::move(channels));
}

Result<std::unique_ptr<FoxgloveRelay>> FoxgloveRelay::join(int domain, view::WebServer& server,
                                                           view::FoxgloveEndpoint& endpoint) {
  auto participant = bus::Participant::create(domain);
  if (!participant) return Failure(participant.error());
  std::unique_ptr<FoxgloveRelay> relay(new FoxgloveRelay());
  for (std::size_t k = 0; k < kTopics; ++k) {
    const auto& entry = topics::recorded[k];
    const msgs::MessageType* type = msgs::find_message_type(entry.type);
    if (!type) return fail(ErrorCode::internal, "its type is not in the table", entry.topic);
    auto made = bus::RawSubscription::create(
        *participant, *type, entry.topic,
        entry.latched ? bus::Qos::latched_last(16) : bus::Qos::sensor_data(),
        [&server, &endpoint, k](std::span<const std::byte> cdr, std::int64_t ns) {
          if (endpoint.wanted(k))
            endpoint.publish(server, k, ns, {reinterpret_cast<const char*>(cdr.data()), cdr.size()});
        });
    if (!made) return Failure(made.error());
    relay->subscriptions_.push_back(std::move(*made));
  }
  return relay;
}

void show_world(view::FoxgloveEndpoint& endpoint, view::WebServer& server,
                const std::vector<planning::Primitive>& solids) {
  const std::int64_t ns = bus::wall_clock_ns();
  endpoint.publish(server, world_entity, ns, view::world_message(solids, ns));
}

void show_plan(view::FoxgloveEndpoint& endpoint, view::WebServer& server, const std::vector<Vec3>& path) {
  const std::int64_t ns = bus::wall_clock_ns();
  endpoint.publish(server, plan_entity, ns, view::plan_message(path, ns));
}

void show_frame(view::FoxgloveEndpoint& endpoint, view::WebServer& server, const vehicle::Vehicle& vehicle,
                const view::Frame& frame) {
  const std::int64_t ns = bus::wall_clock_ns();
  if (endpoint.wanted(transform)) {
    const std::string message = view::transform_message(frame, ns);
    if (!message.empty()) endpoint.publish(server, transform, ns, message);
  }
  if (endpoint.wanted(vehicle_entity))
    endpoint.publish(server, vehicle_entity, ns, view::vehicle_message(vehicle, frame, ns));
}

}  // namespace omniflight::cli
