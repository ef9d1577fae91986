#include <atomic>
#include <cstring>
#include <mutex>
#include <vector>

#include "bus_fixture.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::actuator_msgs::Actuators;
using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::geometry_msgs::PoseStamped;

Message<PoseStamped> known_pose() {
  Message<PoseStamped> pose;
  pose->header.stamp = {1, 2};
  set_text(pose->header.frame_id, "world");
  pose->pose.position = {1.5, -2.5, 3.25};
  pose->pose.orientation = {0.0, 0.6, 0.0, 0.8};
  return pose;
}

/// The bytes that the CDR rules give, written without the middleware.
std::vector<std::byte> known_pose_cdr() {
  std::vector<std::byte> out = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  const auto put = [&out](const auto& value, std::size_t align) {
    while ((out.size() - 4) % align != 0) out.push_back(std::byte{0});
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof(value));
  };
  put(std::int32_t{1}, 4);
  put(std::uint32_t{2}, 4);
  put(std::uint32_t{6}, 4);
  put("world", 1);
  for (const double value : {1.5, -2.5, 3.25, 0.0, 0.6, 0.0, 0.8}) put(value, 8);
  return out;
}

using PublishSubscribe = BusTest;

TEST_F(PublishSubscribe, APoseArrivesUnchangedWithItsSourceTime) {
  const Participant one = join(), two = join();
  auto publisher = Publisher<PoseStamped>::create(one, "/omni/pose");
  ASSERT_TRUE(publisher) << publisher.error().text();
  std::atomic<int> count{0};
  std::int64_t seen_ns = 0;
  double x = 0.0, qy = 0.0;
  std::string frame;
  auto subscription = Subscription<PoseStamped>::create(two, "/omni/pose", Qos::standard(),
                                                        [&](const PoseStamped& pose, std::int64_t source_ns) {
                                                          seen_ns = source_ns;
                                                          x = pose.pose.position.x;
                                                          qy = pose.pose.orientation.y;
                                                          frame = text(pose.header.frame_id);
                                                          ++count;
                                                        });
  ASSERT_TRUE(subscription) << subscription.error().text();
  ASSERT_TRUE(publisher->wait_for_peers(1, 5s));
  ASSERT_TRUE(publisher->publish(*known_pose(), 123456789));
  ASSERT_TRUE(eventually([&] { return count == 1; }));
  EXPECT_EQ(seen_ns, 123456789);
  EXPECT_EQ(x, 1.5);
  EXPECT_EQ(qy, 0.6);
  EXPECT_EQ(frame, "world");
  EXPECT_EQ(publisher->sent(), 1u);
  EXPECT_EQ(subscription->received(), 1u);
}

TEST_F(PublishSubscribe, RawBytesAreTheCdrOfTheMessage) {
  const Participant participant = join();
  const auto* type = msgs::find_message_type("geometry_msgs/msg/PoseStamped");
  std::vector<std::byte> bytes;
  std::int64_t seen_ns = 0;
  auto raw = RawSubscription::create(participant, *type, "/omni/pose", Qos::bulk(),
                                     [&](std::span<const std::byte> cdr, std::int64_t source_ns) {
                                       bytes.assign(cdr.begin(), cdr.end());
                                       seen_ns = source_ns;
                                     });
  ASSERT_TRUE(raw) << raw.error().text();
  auto publisher = Publisher<PoseStamped>::create(participant, "/omni/pose");
  ASSERT_TRUE(publisher->publish(*known_pose(), 77));
  ASSERT_TRUE(eventually([&] { return raw->received() == 1; }));
  EXPECT_EQ(bytes.size(), 84u);
  EXPECT_EQ(bytes, known_pose_cdr());
  EXPECT_EQ(seen_ns, 77);
}

TEST_F(PublishSubscribe, RawBytesCarryNoPadding) {
  const Participant participant = join();
  std::vector<std::vector<std::byte>> seen;
  auto raw = RawSubscription::create(
      participant, *msgs::find_message_type("std_msgs/msg/String"), "/text", Qos::bulk(),
      [&](std::span<const std::byte> cdr, std::int64_t) { seen.emplace_back(cdr.begin(), cdr.end()); });
  auto publisher = Publisher<msgs::std_msgs::String>::create(participant, "/text");
  Message<msgs::std_msgs::String> message;
  for (const char* text : {"", "a", "ab", "abc", "abcd"}) {
    set_text(message->data, text);
    ASSERT_TRUE(publisher->publish(*message, 1));
    const std::size_t length = std::strlen(text);
    std::vector<std::byte> expected(8 + length + 1, std::byte{0});
    expected[1] = std::byte{1};
    expected[4] = static_cast<std::byte>(length + 1);
    std::memcpy(expected.data() + 8, text, length);
    ASSERT_FALSE(seen.empty());
    EXPECT_EQ(seen.back(), expected) << text;
  }
}

TEST_F(PublishSubscribe, SequencesAndNestedStringsArriveByTake) {
  const Participant participant = join();
  auto publisher = Publisher<DiagnosticArray>::create(participant, "/diagnostics");
  auto subscription = Subscription<DiagnosticArray>::create(participant, "/diagnostics");
  ASSERT_TRUE(publisher && subscription);
  Message<DiagnosticArray> sent, taken;
  std::int64_t source_ns = 0;
  EXPECT_FALSE(*subscription->take(taken, source_ns, 5ms)) << "nothing was published yet";
  resize(sent->status, 2);
  sent->status._buffer[1].level = msgs::diagnostic_msgs::DiagnosticStatus_WARN;
  set_text(sent->status._buffer[1].name, "rotor 3");
  resize(sent->status._buffer[1].values, 1);
  set_text(sent->status._buffer[1].values._buffer[0].value, "hot");
  ASSERT_TRUE(publisher->publish(*sent, 5));
  auto got = subscription->take(taken, source_ns, 5s);
  ASSERT_TRUE(got && *got);
  ASSERT_EQ(view(taken->status).size(), 2u);
  const auto& status = view(taken->status)[1];
  EXPECT_EQ(status.level, 1);
  EXPECT_EQ(text(status.name), "rotor 3");
  EXPECT_EQ(text(view(status.values)[0].value), "hot");
  EXPECT_EQ(text(status.message), "");
}

TEST_F(PublishSubscribe, LatchedMessageReachesALateSubscriber) {
  const Participant participant = join();
  auto publisher = Publisher<Actuators>::create(participant, "/state", Qos::latched_last());
  Message<Actuators> message;
  assign(message->velocity, std::vector<double>{100.0, 200.0});
  ASSERT_TRUE(publisher->publish(*message, 1));
  auto late = Subscription<Actuators>::create(participant, "/state", Qos::latched_last());
  Message<Actuators> taken;
  std::int64_t source_ns = 0;
  auto got = late->take(taken, source_ns, 5s);
  ASSERT_TRUE(got && *got);
  EXPECT_EQ(view(taken->velocity)[1], 200.0);
}

TEST_F(PublishSubscribe, PublishingFromACallbackOfTheSameTopicIsRefused) {
  const Participant participant = join();
  auto publisher = Publisher<PoseStamped>::create(participant, "/omni/pose");
  std::string message;
  auto subscription = Subscription<PoseStamped>::create(participant, "/omni/pose", Qos::standard(),
                                                        [&](const PoseStamped& pose, std::int64_t) {
                                                          const Status again = publisher->publish(pose, 2);
                                                          if (!again) message = again.error().text();
                                                        });
  ASSERT_TRUE(publisher->publish(*known_pose(), 1));
  EXPECT_NE(message.find("/omni/pose"), std::string::npos);
  EXPECT_EQ(publisher->sent(), 1u);
}

TEST_F(PublishSubscribe, TwoPublishingThreadsCallASubscriptionOneAtATime) {
  const Participant participant = join();
  std::atomic<int> inside{0}, overlaps{0};
  auto subscription = Subscription<PoseStamped>::create(participant, "/omni/pose", Qos::control(64),
                                                        [&](const PoseStamped&, std::int64_t) {
                                                          if (++inside != 1) ++overlaps;
                                                          std::this_thread::yield();
                                                          --inside;
                                                        });
  const auto send = [&] {
    auto publisher = Publisher<PoseStamped>::create(participant, "/omni/pose", Qos::control(64));
    const Message<PoseStamped> pose = known_pose();
    for (int i = 0; i < 5000; ++i) EXPECT_TRUE(publisher->publish(*pose, i));
  };
  std::thread one(send), two(send);
  one.join();
  two.join();
  EXPECT_EQ(overlaps, 0);
  EXPECT_EQ(subscription->received(), 10000u);
}

TEST_F(PublishSubscribe, NothingIsCalledAfterDestruction) {
  const Participant participant = join();
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    auto publisher = Publisher<PoseStamped>::create(participant, "/omni/pose", Qos::control());
    const Message<PoseStamped> pose = known_pose();
    while (!stop) ASSERT_TRUE(publisher->publish(*pose, 1));
  });
  for (int i = 0; i < 200; ++i) {
    auto alive = std::make_unique<std::atomic<bool>>(true);
    std::atomic<int> late{0}, calls{0};
    {
      auto subscription = Subscription<PoseStamped>::create(participant, "/omni/pose", Qos::control(),
                                                            [&](const PoseStamped&, std::int64_t) {
                                                              ++calls;
                                                              if (!*alive) ++late;
                                                            });
      EXPECT_TRUE(eventually([&] { return calls > 2; }));
    }
    *alive = false;
    std::this_thread::sleep_for(200us);
    EXPECT_EQ(late, 0);
  }
  stop = true;
  writer.join();
}

TEST_F(PublishSubscribe, BadNamesAndDepthsAreRefused) {
  const Participant participant = join();
  for (const char* name : {"", "/", "a//b", "/1a", "a/", "a b", "a-b"}) {
    EXPECT_FALSE(Publisher<PoseStamped>::create(participant, name)) << name;
  }
  EXPECT_FALSE(Publisher<PoseStamped>::create(participant, "/a", Qos::control(0)));
  auto publisher = Publisher<PoseStamped>::create(participant, "/a");
  EXPECT_FALSE(publisher->publish(*known_pose(), -1)) << "a time before the epoch";
}

}  // namespace
}  // namespace omniflight::bus
