// A subscription that follows one publisher: a second one is refused and reported, and takes over when the
// first is gone.
#include <atomic>

#include "bus_fixture.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::std_msgs::String;

class OnePublisher : public BusTest {
 protected:
  static void say(Publisher<String>& by, const char* words) {
    Message<String> message;
    set_text(message->data, words);
    ASSERT_TRUE(by.publish(*message, 1));
  }
};

TEST_F(OnePublisher, ASecondOneIsRefusedCountedAndReported) {
  const Participant here = join(), there = join();
  std::atomic<int> first_heard{0}, second_heard{0}, reported{0};
  auto subscription = Subscription<String>::create(
      here, "/one", Qos::control().from_one_publisher(),
      [&](const String& m, std::int64_t) { ++(text(m.data) == "first" ? first_heard : second_heard); },
      [&](const Event& e) { reported += e.kind == EventKind::foreign_publisher ? 1 : 0; });
  ASSERT_TRUE(subscription);
  std::optional<Publisher<String>> first, second;
  first.emplace(std::move(*Publisher<String>::create(here, "/one", Qos::control())));
  second.emplace(std::move(*Publisher<String>::create(there, "/one", Qos::control())));
  ASSERT_TRUE(subscription->wait_for_peers(2, 5s));
  ASSERT_TRUE(second->wait_for_peers(1, 5s));
  for (int k = 0; k < 5; ++k) {
    say(*first, "first");
    say(*second, "second");
  }
  ASSERT_TRUE(eventually([&] { return subscription->foreign() == 5; }));
  EXPECT_EQ(first_heard, 5);
  EXPECT_EQ(second_heard, 0);
  EXPECT_EQ(reported, 5);
  EXPECT_EQ(subscription->received(), 5u);

  first.reset();  // gone: the other one takes its place
  EXPECT_TRUE(eventually([&] {
    say(*second, "second");
    return second_heard > 0;
  }));
}

TEST_F(OnePublisher, OneThatHasBeenSilentForASecondIsReplaced) {
  const Participant here = join();
  std::atomic<int> second_heard{0};
  auto subscription = Subscription<String>::create(
      here, "/one", Qos::control().from_one_publisher(),
      [&](const String& m, std::int64_t) { second_heard += text(m.data) == "second" ? 1 : 0; });
  ASSERT_TRUE(subscription);
  auto first = Publisher<String>::create(here, "/one", Qos::control());
  auto second = Publisher<String>::create(here, "/one", Qos::control());
  say(*first, "first");
  say(*second, "second");
  EXPECT_EQ(second_heard, 0);
  std::this_thread::sleep_for(1050ms);
  say(*second, "second");
  EXPECT_EQ(second_heard, 1);
}

}  // namespace
}  // namespace omniflight::bus
