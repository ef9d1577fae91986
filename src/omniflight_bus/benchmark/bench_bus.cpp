// Round trip of a 200-byte message over the bus: ping by this thread, pong by the callback of the peer.
#include <benchmark/benchmark.h>

#include <atomic>

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

}  // namespace

BENCHMARK_MAIN();
