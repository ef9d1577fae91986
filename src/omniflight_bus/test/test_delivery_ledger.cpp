#include <sys/wait.h>
#include <unistd.h>

#include <atomic>

#include "bus_fixture.hpp"
#include "omniflight_bus/component.hpp"
#include "omniflight_bus/delivery_ledger.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::omniflight_msgs::ComponentState;
using msgs::omniflight_msgs::RotorTelemetry;

Message<ComponentState> state(const char* name, std::uint64_t sent) {
  Message<ComponentState> out;
  set_text(out->name, name);
  resize(out->topics, 1);
  resize(out->sent, 1);
  set_text(view(out->topics)[0], "/imu");
  view(out->sent)[0] = sent;
  return out;
}

TEST(DeliveryLedger, AddsComponentsAndSurvivesARestart) {
  DeliveryLedger ledger;
  EXPECT_EQ(ledger.lost("/imu", 0), 0u);
  ledger.note(*state("simulator", 100));
  ledger.note(*state("gateway", 7));
  EXPECT_EQ(ledger.lost("/imu", 104), 3u);
  ledger.note(*state("simulator", 5));
  EXPECT_EQ(ledger.sent("/imu"), 112u);
  EXPECT_EQ(ledger.lost("/imu", 200), 0u);
  EXPECT_EQ(ledger.sent("/im"), 0u);
}

/// Sends as fast as it can on a topic of which only the last two messages are kept.
class Burst : public Component {
 public:
  Burst() : Component("burst") {}

 protected:
  Status on_configure(const YAML::Node&) override {
    auto publisher = advertise<RotorTelemetry>("/rotors", Qos::control(2));
    if (!publisher) return Failure(publisher.error());
    publisher_.emplace(std::move(*publisher));
    return {};
  }
  Status on_activate() override {
    if (Status met = publisher_->wait_for_peers(1, 10s); !met) return met;
    Message<RotorTelemetry> message;
    resize(message->velocity, 100);
    for (int i = 0; i < 3000; ++i) {
      if (Status sent = publisher_->publish(*message, i); !sent) return sent;
    }
    return {};
  }
  Status on_cleanup() override {
    publisher_.reset();
    return {};
  }

 private:
  std::optional<Publisher<RotorTelemetry>> publisher_;
};

using Delivery = BusTest;

TEST_F(Delivery, EveryMessageASlowReaderMissedIsCounted) {
  const pid_t sender = fork();
  if (sender == 0) {
    Burst burst;
    const Participant participant = join();
    const bool good = burst.configure(participant, YAML::Node()) && burst.activate() && burst.deactivate();
    std::this_thread::sleep_for(1s);  // a latched message lives as long as its publisher
    _exit(good && burst.shutdown() ? 0 : 1);
  }
  const Participant participant = join();
  DeliveryLedger ledger;
  std::atomic<bool> ended{false};
  auto states = Subscription<ComponentState>::create(participant, "/component_state", Qos::latched_last(16),
                                                     [&](const ComponentState& now, std::int64_t) {
                                                       ledger.note(now);
                                                       ended = ended || text(now.state) == "finalized";
                                                     });
  auto rotors = Subscription<RotorTelemetry>::create(
      participant, "/rotors", Qos::control(2),
      [](const RotorTelemetry&, std::int64_t) { std::this_thread::sleep_for(200us); });
  ASSERT_TRUE(states && rotors);
  int status = -1;
  waitpid(sender, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(eventually([&] { return ended.load(); }));
  EXPECT_EQ(ledger.sent("/rotors"), 3000u);
  EXPECT_LT(rotors->received(), 3000u) << "this reader is meant to be too slow";
  EXPECT_EQ(ledger.lost("/rotors", rotors->received()), 3000u - rotors->received());
}

}  // namespace
}  // namespace omniflight::bus
