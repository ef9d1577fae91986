// Publishing and delivering in one process allocates nothing once every message has had its largest size.
#include <atomic>
#include <cstdlib>

#include "bus_fixture.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define OMNIFLIGHT_COUNTS_ALLOCATIONS 0  // the sanitizer has put its own allocator here
#else
#define OMNIFLIGHT_COUNTS_ALLOCATIONS 1
namespace {
thread_local long g_allocations = 0;  // by thread: the middleware's own threads do their own work meanwhile
}
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* malloc(std::size_t size) { return ++g_allocations, __libc_malloc(size); }
void* calloc(std::size_t n, std::size_t size) { return ++g_allocations, __libc_calloc(n, size); }
void* realloc(void* old, std::size_t size) { return ++g_allocations, __libc_realloc(old, size); }
}
#endif

namespace omniflight::bus {
namespace {

using HotPath = BusTest;

TEST_F(HotPath, PublishingToTwoSubscriptionsAllocatesNothing) {
#if OMNIFLIGHT_COUNTS_ALLOCATIONS
  using msgs::actuator_msgs::Actuators;
  const Participant participant = join();
  long delivered = 0;
  auto publisher = Publisher<Actuators>::create(participant, "/cmd", Qos::control());
  auto typed = Subscription<Actuators>::create(participant, "/cmd", Qos::control(),
                                               [&](const Actuators&, std::int64_t) { ++delivered; });
  auto raw = RawSubscription::create(participant, msgs::TypeSupport<Actuators>::type(), "/cmd", Qos::bulk(),
                                     [&](std::span<const std::byte>, std::int64_t) { ++delivered; });
  ASSERT_TRUE(publisher && typed && raw);
  Message<Actuators> message;
  set_text(message->header.frame_id, "body");
  resize(message->velocity, 8);
  const auto publish = [&](int n) {
    for (int i = 0; i < n; ++i) (void)publisher->publish(*message, i);
  };
  publish(1000);
  const long before = g_allocations;
  publish(1000);
  EXPECT_EQ(g_allocations - before, 0);
  EXPECT_GT(before, 0) << "the counter works";
  EXPECT_EQ(delivered, 4000);
#else
  GTEST_SKIP() << "allocations belong to the sanitizer in this build";
#endif
}

}  // namespace
}  // namespace omniflight::bus
