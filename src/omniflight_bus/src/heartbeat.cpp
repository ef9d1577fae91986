#include "omniflight_bus/heartbeat.hpp"

#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::std_msgs::String;
using SteadyClock = std::chrono::steady_clock;

constexpr int kBeats = 4;  // in a lease
constexpr std::size_t kMostNames = 64;

Qos leased(std::chrono::milliseconds lease) {
  Qos qos = Qos::control(4);
  qos.liveliness_lease_ns = qos.deadline_ns = std::chrono::nanoseconds(lease).count();
  return qos;
}

}  // namespace

struct Heartbeat::State {
  std::optional<Publisher<String>> publisher;
  Message<String> message;
  std::mutex mutex;
  std::condition_variable changed;
  bool ended = false;
  std::thread thread;

  ~State() {
    {
      const std::lock_guard lock(mutex);
      ended = true;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
  }
  void beat(std::chrono::milliseconds period) {
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, period, [this] { return ended; })) (void)publisher->publish(*message);
  }
};

Heartbeat::Heartbeat(std::unique_ptr<State> state) : state_(std::move(state)) {}
Heartbeat::Heartbeat(Heartbeat&&) noexcept = default;
Heartbeat& Heartbeat::operator=(Heartbeat&&) noexcept = default;
Heartbeat::~Heartbeat() = default;

Result<Heartbeat> Heartbeat::start(const Participant& participant, const std::string& name,
                                   std::chrono::milliseconds lease) {
  auto state = std::make_unique<State>();
  auto made = Publisher<String>::create(participant, heartbeat_topic, leased(lease));
  if (!made) return Failure(made.error());
  state->publisher.emplace(std::move(*made));
  set_text(state->message->data, name);
  State* self = state.get();
  const auto period = std::max(std::chrono::milliseconds(1), lease / kBeats);
  state->thread = std::thread([self, period] { self->beat(period); });
  return Heartbeat(std::move(state));
}

struct HeartbeatWatch::State {
  struct Member {
    SteadyClock::time_point heard;
    bool alive = true;
  };
  std::chrono::milliseconds lease{0};
  Callback callback;
  std::mutex mutex;
  std::map<std::string, Member> members;  ///< guarded by mutex
  std::optional<Subscription<String>> subscription;

  static double seconds(SteadyClock::duration d) { return std::chrono::duration<double>(d).count(); }

  void heard(const std::string& name) {
    const auto now = SteadyClock::now();
    std::optional<double> silence;
    {
      const std::lock_guard lock(mutex);
      const auto known = members.find(name);
      if (known == members.end()) {
        if (members.size() < kMostNames) members[name] = {now, true};
        return;
      }
      if (!known->second.alive) silence = seconds(now - known->second.heard);
      known->second = {now, true};
    }
    if (silence) callback(name, true, *silence);
  }

  /// A lease has ended: whose, the time since the last beat tells. The others have beaten since.
  void lease_ended() {
    const auto now = SteadyClock::now();
    const auto late = lease - lease / kBeats;
    std::map<std::string, double> silent;
    {
      const std::lock_guard lock(mutex);
      for (auto& [name, member] : members) {
        if (!member.alive || now - member.heard < late) continue;
        member.alive = false;
        silent[name] = seconds(now - member.heard);
      }
    }
    for (const auto& [name, silence] : silent) callback(name, false, silence);
  }
};

HeartbeatWatch::HeartbeatWatch(std::unique_ptr<State> state) : state_(std::move(state)) {}
HeartbeatWatch::HeartbeatWatch(HeartbeatWatch&&) noexcept = default;
HeartbeatWatch& HeartbeatWatch::operator=(HeartbeatWatch&&) noexcept = default;
HeartbeatWatch::~HeartbeatWatch() = default;

Result<HeartbeatWatch> HeartbeatWatch::start(const Participant& participant, std::chrono::milliseconds lease,
                                             Callback callback) {
  auto state = std::make_unique<State>();
  state->lease = lease;
  state->callback = std::move(callback);
  State* self = state.get();
  auto made = Subscription<String>::create(
      participant, heartbeat_topic, leased(lease),
      [self](const String& m, std::int64_t) { self->heard(std::string(text(m.data))); },
      [self](const Event& event) {
        if (event.kind == EventKind::liveliness_changed || event.kind == EventKind::deadline_missed)
          self->lease_ended();
      });
  if (!made) return Failure(made.error());
  state->subscription.emplace(std::move(*made));
  return HeartbeatWatch(std::move(state));
}

}  // namespace omniflight::bus
