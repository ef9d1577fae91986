// Round trip of a 200-byte message over the bus: ping by this thread, pong by the callback of the peer.
#include <benchmark/benchmark.h>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace {

using namespace omniflight;
using msgs::actuator_msgs::Actuators;

void round_trip(benchmark::State& state) {
  auto claim = bus::claim_free_domain();
  auto one = bus::Participant::create(claim->domain());
  auto two = bus::Participant::create(claim->domain());
  auto pong = bus::Publisher<Actuators>::create(*two, "/pong", bus::Qos::control());
  std::uint64_t returned = 0;
  auto there = bus::Subscription<Actuators>::create(
      *two, "/ping", bus::Qos::control(),
      [&](const Actuators& message, std::int64_t ns) { (void)pong->publish(message, ns); });
  auto back = bus::Subscription<Actuators>::create(*one, "/pong", bus::Qos::control(),
                                                   [&](const Actuators&, std::int64_t) { ++returned; });
  auto ping = bus::Publisher<Actuators>::create(*one, "/ping", bus::Qos::control());
  bus::Message<Actuators> message;
  bus::set_text(message->header.frame_id, "body");
  bus::resize(message->position, 1);
  bus::resize(message->velocity, 8);
  bus::resize(message->normalized, 8);
  std::int64_t ns = 0;
  std::uint64_t sent = 0;
  for (auto _ : state) {
    if (!ping->publish(*message, ++ns)) state.SkipWithError("not sent");
    if (returned != ++sent) state.SkipWithError("no answer inside publish");
  }
}
BENCHMARK(round_trip)->Unit(benchmark::kMicrosecond);

/// The same with the peer in another process, over the loopback interface.
void round_trip_two_processes(benchmark::State& state) {
  auto claim = bus::claim_free_domain();
  const pid_t peer = fork();
  if (peer == 0) {
    auto two = bus::Participant::create(claim->domain());
    auto pong = bus::Publisher<Actuators>::create(*two, "/pong", bus::Qos::control());
    auto there = bus::Subscription<Actuators>::create(
        *two, "/ping", bus::Qos::control(),
        [&](const Actuators& message, std::int64_t ns) { (void)pong->publish(message, ns); });
    for (;;) pause();
  }
  {
    auto one = bus::Participant::create(claim->domain());
    std::atomic<std::int64_t> answered{0};
    auto back = bus::Subscription<Actuators>::create(*one, "/pong", bus::Qos::control(),
                                                     [&](const Actuators&, std::int64_t ns) {
                                                       answered = ns;
                                                       answered.notify_one();
                                                     });
    auto ping = bus::Publisher<Actuators>::create(*one, "/ping", bus::Qos::control());
    bus::Message<Actuators> message;
    bus::resize(message->velocity, 8);
    bool met = ping->wait_for_peers(1, std::chrono::seconds(10)) &&
               back->wait_for_peers(1, std::chrono::seconds(10));
    for (std::int64_t ns = -100; met && answered == 0 && ns < 0; ++ns) {  // until both know each other
      met = ping->publish(*message, 1).has_value();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (!met || answered == 0) state.SkipWithError("no peer");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::int64_t ns = 1;
    for (auto _ : state) {
      if (!ping->publish(*message, ++ns)) state.SkipWithError("not sent");
      for (std::int64_t seen = answered; seen != ns; seen = answered) answered.wait(seen);
    }
  }
  kill(peer, SIGKILL);
  waitpid(peer, nullptr, 0);
}
BENCHMARK(round_trip_two_processes)->Unit(benchmark::kMicrosecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
