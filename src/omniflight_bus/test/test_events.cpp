#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>

#include "bus_fixture.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::geometry_msgs::PoseStamped;
using Events = BusTest;

TEST_F(Events, AMissedDeadlineIsReported) {
  const Participant participant = join();
  Qos qos = Qos::control();
  qos.deadline_ns = 50'000'000;
  std::atomic<int> misses{0};
  auto publisher = Publisher<PoseStamped>::create(participant, "/cmd", qos);
  auto subscription = Subscription<PoseStamped>::create(
      participant, "/cmd", qos, [](const PoseStamped&, std::int64_t) {},
      [&](const Event& event) { misses += event.kind == EventKind::deadline_missed; });
  ASSERT_TRUE(publisher && subscription);
  const Message<PoseStamped> pose;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(publisher->publish(*pose, i));
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_EQ(misses, 0) << "messages came in time";
  EXPECT_TRUE(eventually([&] { return misses > 0; }, 1s)) << "the publisher fell silent";
}

TEST_F(Events, ALeaseThatIsNotRenewedIsReported) {
  const Participant participant = join();
  Qos qos = Qos::control();
  qos.liveliness_lease_ns = 50'000'000;
  std::atomic<int> alive{-1};
  auto subscription = Subscription<PoseStamped>::create(
      participant, "/cmd", qos, [](const PoseStamped&, std::int64_t) {},
      [&](const Event& event) {
        if (event.kind == EventKind::liveliness_changed) alive = static_cast<int>(event.count);
      });
  auto publisher = Publisher<PoseStamped>::create(participant, "/cmd", qos);
  ASSERT_TRUE(publisher->publish(*Message<PoseStamped>(), 1));
  EXPECT_TRUE(eventually([&] { return alive == 1; }));
  EXPECT_TRUE(eventually([&] { return alive == 0; }));
}

TEST_F(Events, IncompatibleQosNamesThePolicy) {
  const Participant participant = join();
  std::string policy;
  auto subscription = Subscription<PoseStamped>::create(
      participant, "/cmd", Qos::standard(), [](const PoseStamped&, std::int64_t) {},
      [&](const Event& event) {
        if (event.kind == EventKind::incompatible_qos) policy = event.detail;
      });
  auto publisher = Publisher<PoseStamped>::create(participant, "/cmd", Qos::sensor_data());
  EXPECT_EQ(policy, "reliability");
  const Status waited = publisher->wait_for_peers(1, 10ms);
  ASSERT_FALSE(waited);
  EXPECT_EQ(waited.error().code, ErrorCode::incomplete);
  EXPECT_NE(waited.error().text().find("/cmd"), std::string::npos);
}

TEST_F(Events, AReaderThatHangsDoesNotBlockTheWriter) {
  const pid_t reader = fork();
  if (reader == 0) {
    const Participant participant = join();
    auto subscription = Subscription<PoseStamped>::create(participant, "/cmd", Qos::control(),
                                                          [](const PoseStamped&, std::int64_t) {});
    for (;;) pause();
  }
  const Participant participant = join();
  auto publisher = Publisher<PoseStamped>::create(participant, "/cmd", Qos::control());
  const Status met = publisher->wait_for_peers(1, 10s);
  EXPECT_TRUE(met) << met.error().text();
  kill(reader, SIGSTOP);
  const Message<PoseStamped> pose;
  // a write that waits gives up its processor of its own will; a busy machine takes it away, which is not
  // counted
  const auto waits = [] {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nvcsw;
  };
  const long waits_before = waits();
  double longest = 0.0;
  bool sent = met.has_value();
  for (int i = 0; i < 5000 && sent; ++i) {
    const auto start = std::chrono::steady_clock::now();
    sent = publisher->publish(*pose, i).has_value();
    longest =
        std::max(longest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  kill(reader, SIGKILL);
  waitpid(reader, nullptr, 0);
  EXPECT_TRUE(sent);
  const long blocked = waits() - waits_before;
  std::printf("hung reader: %ld of 5000 writes blocked, the longest took %.2f ms\n", blocked, 1e3 * longest);
  EXPECT_LE(blocked, 50) << "1 % may meet the middleware's own threads at a lock";
  EXPECT_LT(longest, 0.09) << "a KEEP_ALL writer waits 0.1 s here, at each message";
}

TEST(Domain, ASecondClaimIsRefusedUntilTheFirstEnds) {
  auto first = claim_free_domain(101, 150);
  ASSERT_TRUE(first) << first.error().text();
  const int domain = first->domain();
  const auto second = claim_domain(domain);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::bad_input);
  EXPECT_NE(second.error().text().find("domain " + std::to_string(domain) + " is in use"), std::string::npos);
  EXPECT_NE(second.error().text().find(std::to_string(getpid())), std::string::npos);
  { const DomainClaim ended = std::move(*first); }
  EXPECT_TRUE(claim_domain(domain));
  EXPECT_FALSE(claim_domain(-1));
  EXPECT_FALSE(claim_domain(max_domain + 1));
}

}  // namespace
}  // namespace omniflight::bus
