// A NatNet server without cameras: streams the poses of the emulated world by multicast, on a clock of its
// own.
#include <mutex>

#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/natnet_config.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_gateway/udp_socket.hpp"
#include "threaded_component.hpp"
#include "wall_pace.hpp"

namespace omniflight::components {
namespace {

using gateway::NatNetMessage;
using msgs::geometry_msgs::PoseStamped;

constexpr std::uint64_t kClock = 10'000'000;  // Hz, of the emulated server's ticks
constexpr double kAhead = 86'400.0;           // s that its clock is ahead of flight time: a day up

class NatNetEmulator final : public ThreadedComponent {
 public:
  NatNetEmulator() : ThreadedComponent("natnet_emulator") {}
  ~NatNetEmulator() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "natnet_emulator");
    const std::string file = p.text("config", {}), version = p.text("version", "4.1");
    const std::string topic = p.text("mocap_topic", topics::emulated_mocap);
    pace_.emplace(p.integer("epoch_monotonic_ns", 0, 0));
    if (auto ok = p.finish(); !ok) return ok;
    auto config = load_natnet(file);
    if (!config) return Failure(config.error());
    config_ = std::move(*config);
    auto read = natnet_version(version, "natnet_emulator.version");
    if (!read) return Failure(read.error());
    server_ = {.name = "omniflight emulator", .version = *read, .clock_hz = kClock};
    auto group = gateway::udp_address(config_.multicast, config_.data_port);
    if (!group) return Failure(group.error());
    group_ = *group;
    auto command = gateway::UdpSocket::bind(config_.server, config_.command_port);
    if (!command) return Failure(command.error());
    command_.emplace(std::move(*command));
    auto data = gateway::UdpSocket::bind(config_.server, 0);
    if (!data) return Failure(data.error());
    data_.emplace(std::move(*data));
    for (std::size_t k = 0; k < config_.bodies.size(); ++k)
      models_[config_.bodies[k].id.value_or(static_cast<std::int32_t>(k) + 1)] = config_.bodies[k].name;
    auto poses = bus::Subscription<PoseStamped>::create(
        participant(), topic, bus::Qos::bulk(64), [this](const PoseStamped& m, std::int64_t) { stream(m); });
    if (!poses) return Failure(poses.error());
    poses_.emplace(std::move(*poses));
    return {};
  }
  Status on_cleanup() override {
    stop();
    poses_.reset();
    data_.reset();
    command_.reset();
    return {};
  }

  static std::uint64_t ticks(double flight_s) {
    return static_cast<std::uint64_t>(std::llround((flight_s + kAhead) * static_cast<double>(kClock)));
  }

  void stream(const PoseStamped& m) {
    const double taken = to_s(m.header.stamp), now = pace_->now();
    gateway::NatNetBody body;
    body.id = config_.bodies.front().id.value_or(1);
    body.position = get(m.pose.position);
    body.attitude = get_quaternion(m.pose.orientation);
    frame_.number++;
    frame_.bodies = {gateway::from_world(body, config_.up, config_.metres_per_unit)};
    frame_.timestamp_s = now + kAhead;
    frame_.software_latency_s = now - taken;
    frame_.exposed = ticks(taken);
    frame_.received = frame_.sent = ticks(now);
    gateway::write_natnet_frame(frame_, server_.version, bytes_);
    (void)data_->send(bytes_, group_);  // who listens does so by himself
  }

  /// Answers questions until the end.
  Status run() override {
    std::vector<std::byte> answer;
    while (running()) {
      gateway::UdpAddress from;
      auto question = command_->receive(0.02, &from);
      if (!question) return Failure(question.error());
      const auto kind = question->empty() ? Result<NatNetMessage>(bad_input("nothing", ""))
                                          : gateway::natnet_message(*question);
      if (!kind) continue;
      if (*kind == NatNetMessage::connect)
        gateway::write_natnet_server(server_, answer);
      else if (*kind == NatNetMessage::request_models)
        gateway::write_natnet_models(models_, server_.version, answer);
      else
        continue;
      (void)command_->send(answer, from);
    }
    return {};
  }

  NatNetConfig config_;
  std::optional<WallPace> pace_;
  gateway::NatNetServer server_;
  gateway::NatNetModels models_;
  gateway::UdpAddress group_;
  std::optional<gateway::UdpSocket> command_, data_;
  gateway::NatNetFrame frame_;
  std::vector<std::byte> bytes_;
  std::optional<bus::Subscription<PoseStamped>> poses_;
};

}  // namespace

std::unique_ptr<bus::Component> make_natnet_emulator() { return std::make_unique<NatNetEmulator>(); }

}  // namespace omniflight::components
