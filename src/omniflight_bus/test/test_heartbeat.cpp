// A process that stands still is noticed when its lease ends, and heard again when it goes on.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <mutex>
#include <thread>

#include "bus_fixture.hpp"
#include "omniflight_bus/heartbeat.hpp"

namespace omniflight::bus {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLease = 100ms;
constexpr double kBusy = 0.1;  // s that this machine may keep a thread from running

struct Heard {
  std::mutex mutex;
  struct Word {
    std::string name;
    bool alive;
    double silence_s;
    Clock::time_point at;
  };
  std::vector<Word> words;
  void operator()(const std::string& name, bool alive, double silence_s) {
    const std::lock_guard lock(mutex);
    words.push_back({name, alive, silence_s, Clock::now()});
  }
  void clear() {
    const std::lock_guard lock(mutex);
    words.clear();
  }
  std::optional<Word> find(const std::string& name, bool alive) {
    const std::lock_guard lock(mutex);
    for (const Word& w : words)
      if (w.name == name && w.alive == alive) return w;
    return {};
  }
};

/// A process of its own that beats until it is killed.
class Beating {
 public:
  explicit Beating(int domain) {
    pid_ = fork();
    if (pid_ != 0) return;
    const auto participant = Participant::create(domain);
    if (!participant) _exit(1);
    const auto beat = Heartbeat::start(*participant, "other", kLease);
    if (!beat) _exit(1);
    for (int k = 0; k < 600; ++k) std::this_thread::sleep_for(100ms);  // a minute, should nobody kill it
    _exit(0);
  }
  ~Beating() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  void send(int signal) const { kill(pid_, signal); }

 private:
  pid_t pid_ = -1;
};

class HeartbeatTest : public BusTest {
 protected:
  int domain() const { return claim->domain(); }
};

TEST_F(HeartbeatTest, AStoppedProcessIsNoticedWithinItsLeaseAndRejoins) {
  const Beating other(domain());  // forked before this process has threads
  const Participant participant = join();
  auto heard = std::make_shared<Heard>();
  auto watch = HeartbeatWatch::start(participant, kLease,
                                     [heard](const auto& n, bool a, double s) { (*heard)(n, a, s); });
  ASSERT_TRUE(watch) << watch.error().text();
  const auto own = Heartbeat::start(participant, "own", kLease);
  ASSERT_TRUE(own);
  std::this_thread::sleep_for(1500ms);  // both have met
  double soonest = 1e9, latest_back = 0;
  for (int k = 0; k < 5; ++k) {
    heard->clear();
    other.send(SIGSTOP);
    ASSERT_TRUE(eventually([&] { return heard->find("other", false).has_value(); }, 2000ms))
        << "nobody noticed";
    const double silence = heard->find("other", false)->silence_s;
    soonest = std::min(soonest, silence);
    EXPECT_LT(silence, 0.105 + kBusy);
    EXPECT_GT(silence, 0.07);
    std::this_thread::sleep_for(200ms);
    other.send(SIGCONT);
    const auto continued = Clock::now();
    ASSERT_TRUE(eventually([&] { return heard->find("other", true).has_value(); }, 2000ms))
        << "it did not rejoin";
    const auto back = *heard->find("other", true);
    EXPECT_GT(back.silence_s, 0.2);
    latest_back = std::max(latest_back, std::chrono::duration<double>(back.at - continued).count());
    std::this_thread::sleep_for(200ms);
  }
  std::printf(
      "a lease of 100 ms, stopped 5 times: noticed %.1f ms after the last beat, back at most %.1f ms after "
      "SIGCONT\n",
      1e3 * soonest, 1e3 * latest_back);
  EXPECT_LT(soonest, 0.105) << "the lease and 5 ms, where the machine lets it";
  EXPECT_LT(latest_back, 2.0);
  EXPECT_FALSE(heard->find("own", false)) << "who beats is not silent";
}

TEST_F(HeartbeatTest, AKilledProcessIsNoticedToo) {
  auto other = std::make_unique<Beating>(domain());
  const Participant participant = join();
  auto heard = std::make_shared<Heard>();
  auto watch = HeartbeatWatch::start(participant, kLease,
                                     [heard](const auto& n, bool a, double s) { (*heard)(n, a, s); });
  ASSERT_TRUE(watch);
  std::this_thread::sleep_for(1500ms);
  heard->clear();
  other.reset();
  ASSERT_TRUE(eventually([&] { return heard->find("other", false).has_value(); }, 2000ms));
  EXPECT_LT(heard->find("other", false)->silence_s, 0.105 + kBusy);
}

}  // namespace
}  // namespace omniflight::bus
