// Motion capture over NatNet (OptiTrack) as a source of poses.
#include <algorithm>

#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/say.hpp"
#include "omniflight_components/natnet_config.hpp"
#include "omniflight_gateway/udp_socket.hpp"
#include "omniflight_safety/stamp_clock.hpp"
#include "threaded_component.hpp"
#include "wall_pace.hpp"

namespace omniflight::components {
namespace {

using gateway::NatNetMessage;
using msgs::geometry_msgs::PoseStamped;

constexpr double kAskEvery = 0.5;      // s between two questions to the server
constexpr double kSayEvery = 2.0;      // s between two lines about the same trouble
constexpr double kLongestDelay = 0.5;  // s from exposure to transmission

class NatNet final : public ThreadedComponent {
 public:
  NatNet() : ThreadedComponent("natnet") {}
  ~NatNet() override { stop(); }

 private:
  struct Body {
    std::string name;
    bool asked;  ///< the id is the server's answer
    std::optional<std::int32_t> id;
    std::optional<bus::Publisher<PoseStamped>> publisher;
  };

  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "natnet");
    const std::string file = p.text("config", {});
    epoch_ns_ = p.integer("epoch_monotonic_ns", 0, 0);
    if (auto ok = p.finish(); !ok) return ok;
    auto config = load_natnet(file);
    if (!config) return Failure(config.error());
    config_ = std::move(*config);
    safety::StampClockConfig clock;
    clock.own = false;
    clock_.emplace(clock);
    server_.version = config_.version.value_or(gateway::NatNetVersion{});
    auto host = gateway::udp_address(config_.server, config_.command_port);
    if (!host) return Failure(host.error());
    command_address_ = *host;
    auto data = gateway::UdpSocket::join(config_.multicast, config_.data_port, config_.interface);
    if (!data) return Failure(data.error());
    data_.emplace(std::move(*data));
    auto command = gateway::UdpSocket::bind(config_.interface, 0);
    if (!command) return Failure(command.error());
    command_.emplace(std::move(*command));
    bodies_.clear();
    for (const auto& body : config_.bodies) {
      auto made = advertise<PoseStamped>(body.topic, bus::Qos::bulk(512));
      if (!made) return Failure(made.error());
      bodies_.push_back({body.name, !body.id, body.id, std::move(*made)});
    }
    bus::set_text(message_->header.frame_id, "map");
    return {};
  }
  Status on_cleanup() override {
    stop();
    bodies_.clear();
    data_.reset();
    command_.reset();
    return {};
  }

  bool knows_version() const { return server_.version.major > 0; }
  bool knows_bodies() const {
    return std::all_of(bodies_.begin(), bodies_.end(), [](const Body& b) { return b.id.has_value(); });
  }

  Status run() override {
    const WallPace pace(epoch_ns_);
    double ask_at = pace.now();
    while (running()) {
      const double now = pace.now();
      if (now >= ask_at && (!answered_ || !knows_bodies() || models_changed_)) {
        ask_at = now + kAskEvery;
        if (auto ok = ask(); !ok) return ok;
      }
      gateway::UdpAddress from;
      for (auto answer = command_->receive(0.0, &from); answer && !answer->empty();
           answer = command_->receive(0.0, &from))
        if (is_server(from, now)) take_answer(*answer, now);
      auto data = data_->receive(0.005, &from);
      if (!data) return Failure(data.error());
      if (!data->empty() && is_server(from, pace.now())) take_frame(*data, pace.now());
      if (now - heard_ > kSayEvery)
        say(now, "no frames from " + config_.server + " on " + config_.multicast + ":" +
                     std::to_string(config_.data_port));
    }
    bus::say("natnet",
             std::to_string(frames_) + " frames, " + std::to_string(refused_) + " datagrams refused");
    return {};
  }

  Status ask() {
    if (!answered_) {
      gateway::write_natnet_request(NatNetMessage::connect, bytes_);
      if (auto ok = command_->send(bytes_, command_address_); !ok) return ok;
    }
    if (!knows_version() || (knows_bodies() && !models_changed_)) return {};
    gateway::write_natnet_request(NatNetMessage::request_models, bytes_);
    return command_->send(bytes_, command_address_);
  }

  /// Anybody may send to a multicast group; only the server is listened to.
  bool is_server(const gateway::UdpAddress& from, double now) {
    if (from.host == command_address_.host) return true;
    refuse(now, "a datagram of another computer than " + config_.server);
    return false;
  }

  void take_answer(std::span<const std::byte> bytes, double now) {
    const auto kind = gateway::natnet_message(bytes);
    if (kind && *kind == NatNetMessage::server_info) {
      auto server = gateway::parse_natnet_server(bytes);
      if (!server) return refuse(now, server.error().text());
      if (config_.version) server->version = *config_.version;
      server_ = *server;
      answered_ = true;
      bus::say("natnet",
               "server '" + server_.name + "', bit stream " + gateway::to_string(server_.version));
    } else if (kind && *kind == NatNetMessage::models && knows_version()) {
      const auto models = gateway::parse_natnet_models(bytes, server_.version);
      if (!models) return refuse(now, models.error().text());
      models_changed_ = false;
      for (Body& body : bodies_) {
        if (!body.asked) continue;
        body.id.reset();
        for (const auto& [id, name] : *models)
          if (name == body.name) body.id = id;
        if (body.id) continue;
        std::string known;
        for (const auto& [id, name] : *models) known += (known.empty() ? "" : ", ") + name;
        say(now, "the server streams no rigid body '" + body.name + "'; it has: " + known);
      }
    }
  }

  void take_frame(std::span<const std::byte> bytes, double now) {
    heard_ = now;
    if (!knows_version()) return;
    if (auto ok = gateway::parse_natnet_frame(bytes, server_.version, frame_); !ok)
      return refuse(now, ok.error().text());
    ++frames_;
    models_changed_ = models_changed_ || frame_.models_changed;
    const auto taken = exposed_at(now);
    if (!taken) return;
    for (const gateway::NatNetBody& seen : frame_.bodies)
      for (Body& body : bodies_)
        if (seen.tracked && body.id == seen.id) publish(body, seen, *taken, now);
  }

  /// Flight time [s] of the frame's exposure. The server's clock is followed where it stamps the
  /// transmission: the delay from exposure to there is told by the server and is not lost in the least delay.
  std::optional<double> exposed_at(double now) {
    double sent_s = frame_.timestamp_s, delay_s = frame_.software_latency_s + config_.latency_s;
    if (server_.clock_hz > 0) {
      const double period = 1.0 / static_cast<double>(server_.clock_hz);
      sent_s = period * static_cast<double>(frame_.sent);
      delay_s = period * static_cast<double>(static_cast<std::int64_t>(frame_.sent - frame_.exposed));
    }
    double flight_s = 0;
    const std::uint64_t resets = clock_->resets();
    if (clock_->place(sent_s, now, flight_s)) {
      if (clock_->resets() > 0) refuse(now, clock_->refusal_words());
      return {};
    }
    if (clock_->resets() > resets) bus::say("natnet", clock_->reset_words());
    if (delay_s >= 0 && delay_s <= kLongestDelay) return flight_s - delay_s;
    refuse(now, "an exposure " + std::to_string(delay_s) + " s before its transmission");
    return {};
  }

  void publish(Body& body, const gateway::NatNetBody& seen, double taken_s, double now) {
    if (taken_s < 0) return;
    const gateway::NatNetBody pose = gateway::to_world(seen, config_.up, config_.metres_per_unit);
    message_->header.stamp = bus::stamp(to_ns(taken_s));
    put(message_->pose.position, pose.position);
    put_quaternion(message_->pose.orientation, pose.attitude.normalized());
    (void)body.publisher->publish(*message_, to_ns(now));
  }

  void refuse(double now, const std::string& why) {
    ++refused_;
    say(now, "refused: " + why);
  }
  void say(double now, const std::string& words) {
    if (now < next_word_) return;
    next_word_ = now + kSayEvery;
    bus::say("natnet", words);
  }

  NatNetConfig config_;
  std::int64_t epoch_ns_ = 0;
  gateway::NatNetServer server_;
  gateway::UdpAddress command_address_;
  std::optional<gateway::UdpSocket> data_, command_;
  std::optional<safety::StampClock> clock_;
  std::vector<Body> bodies_;
  std::vector<std::byte> bytes_;
  gateway::NatNetFrame frame_;
  bus::Message<PoseStamped> message_;
  bool models_changed_ = false, answered_ = false;
  double heard_ = 0, next_word_ = 0;
  std::uint64_t frames_ = 0, refused_ = 0;
};

}  // namespace

std::unique_ptr<bus::Component> make_natnet() { return std::make_unique<NatNet>(); }

}  // namespace omniflight::components
