#include <vector>

#include "bus_fixture.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/raw_publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::actuator_msgs::Actuators;
using RawPublisherTest = BusTest;

TEST_F(RawPublisherTest, RecordedBytesArriveAsTheMessageTheyWere) {
  const Participant participant = join();
  const msgs::MessageType& type = msgs::TypeSupport<Actuators>::type();
  std::vector<std::byte> recorded, again;
  {
    auto recorder = RawSubscription::create(
        participant, type, "/cmd", Qos::bulk(),
        [&](std::span<const std::byte> cdr, std::int64_t) { recorded.assign(cdr.begin(), cdr.end()); });
    auto publisher = Publisher<Actuators>::create(participant, "/cmd");
    Message<Actuators> message;
    set_text(message->header.frame_id, "body_1");
    assign(message->velocity, std::vector<double>{1.0, -2.0, 3.0});
    ASSERT_TRUE(publisher->publish(*message, 1));
  }
  ASSERT_FALSE(recorded.empty());

  auto replay = RawPublisher::create(participant, type, "/cmd");
  ASSERT_TRUE(replay) << replay.error().text();
  auto typed = Subscription<Actuators>::create(participant, "/cmd");
  auto raw = RawSubscription::create(
      participant, type, "/cmd", Qos::bulk(),
      [&](std::span<const std::byte> cdr, std::int64_t) { again.assign(cdr.begin(), cdr.end()); });
  ASSERT_TRUE(replay->publish(recorded, 42));
  Message<Actuators> got;
  std::int64_t source_ns = 0;
  auto taken = typed->take(got, source_ns, 5s);
  ASSERT_TRUE(taken && *taken);
  EXPECT_EQ(source_ns, 42);
  EXPECT_EQ(text(got->header.frame_id), "body_1");
  ASSERT_EQ(view(got->velocity).size(), 3u);
  EXPECT_EQ(view(got->velocity)[1], -2.0);
  EXPECT_EQ(again, recorded);
}

TEST_F(RawPublisherTest, BytesThatAreNoMessageAreRefused) {
  const Participant participant = join();
  auto replay = RawPublisher::create(participant, msgs::TypeSupport<Actuators>::type(), "/cmd");
  ASSERT_TRUE(replay) << replay.error().text();
  auto typed = Subscription<Actuators>::create(participant, "/cmd");
  std::vector<std::byte> bytes(24, std::byte{0});
  EXPECT_FALSE(replay->publish({}, 1)) << "nothing";
  bytes[1] = std::byte{7};
  EXPECT_FALSE(replay->publish(bytes, 1)) << "another encoding";
  bytes[1] = std::byte{1};
  bytes[12] = std::byte{0xff};
  bytes[13] = std::byte{0xff};
  const Status refused = replay->publish(bytes, 1);
  ASSERT_FALSE(refused) << "a frame_id longer than the message";
  EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
  EXPECT_NE(refused.error().text().find("actuator_msgs/msg/Actuators"), std::string::npos);
  EXPECT_EQ(typed->received(), 0u);
  Message<Actuators> got;
  std::int64_t source_ns = 0;
  auto taken = typed->take(got, source_ns, 20ms);
  EXPECT_TRUE(taken && !*taken);
}

}  // namespace
}  // namespace omniflight::bus
