// The recorder of a flight, killed at a random moment: what was said up to a tenth of a second before is in
// the file, without a gap.
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_reader.hpp"

namespace {

using namespace omniflight;
using namespace msgs;
using namespace std::chrono_literals;
namespace fs = std::filesystem;
namespace topics = components::topics;

constexpr const char* kLoopback = OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml";
constexpr double kPromise_ms = 100.0;
constexpr std::size_t kMost = 600'000;  // rounds of the publisher, ten minutes

/// 200 in the long tests, see CMakeLists.txt.
int kills() {
  const char* told = std::getenv("OMNIFLIGHT_REPETITIONS");
  return told ? std::max(1, std::atoi(told)) : 8;
}

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Shared with the publisher: when each of its rounds was published on all five topics.
struct Said {
  std::atomic<std::size_t> rounds;
  std::int64_t time_ns[kMost];
};

/// Five topics of a flight at 1 kHz until it is killed.
[[noreturn]] void say(int domain, Said& said) {
  (void)bus::use_loopback(kLoopback);
  const bus::Participant p = bus::Participant::create(domain).value();
  const bus::Qos qos = bus::Qos::bulk(512);
  auto tick = bus::Publisher<omniflight_msgs::Tick>::create(p, topics::tick, qos).value();
  auto imu = bus::Publisher<sensor_msgs::Imu>::create(p, topics::imu, qos).value();
  auto mocap = bus::Publisher<geometry_msgs::PoseStamped>::create(p, topics::mocap, qos).value();
  auto rotors = bus::Publisher<omniflight_msgs::RotorTelemetry>::create(p, topics::rotors, qos).value();
  auto battery = bus::Publisher<sensor_msgs::BatteryState>::create(p, topics::battery, qos).value();
  const bus::Message<omniflight_msgs::Tick> a;
  const bus::Message<sensor_msgs::Imu> b;
  const bus::Message<geometry_msgs::PoseStamped> c;
  const bus::Message<omniflight_msgs::RotorTelemetry> d;
  const bus::Message<sensor_msgs::BatteryState> e;
  for (std::size_t k = 0; k < kMost; ++k) {
    const std::int64_t now = now_ns();
    said.time_ns[k] = now;
    (void)tick.publish(*a, now);
    (void)imu.publish(*b, now);
    (void)mocap.publish(*c, now);
    (void)rotors.publish(*d, now);
    (void)battery.publish(*e, now);
    said.rounds.store(k + 1);
    std::this_thread::sleep_for(1ms);
  }
  ::_exit(0);
}

[[noreturn]] void record(int domain, const fs::path& file) {
  const sched_param first{.sched_priority = 1};
  (void)::sched_setscheduler(0, SCHED_RR, &first);  // as in a flight in real time, where it is allowed
  std::vector<std::unique_ptr<bus::Component>> parts;
  parts.push_back(components::make_component("recorder"));
  bus::RunOptions options;
  options.domain = domain;
  options.loopback_file = kLoopback;
  options.quiet = true;
  options.overrides = {"file:=" + file.string()};
  ::_exit(bus::run_components(std::move(parts), options));
}

struct Loss {
  double ms = 0;           ///< from the first message that is not in the file to the kill, on the worst topic
  std::uint64_t gaps = 0;  ///< places where the recorder's own count of what it received jumps
  std::uint64_t not_received = 0;  ///< rounds between two that are there which the bus did not deliver
};

/// Compares the file with what had been said on all topics before the kill.
Loss loss_of(const fs::path& file, const Said& said, std::size_t rounds, std::int64_t killed_ns) {
  const std::string bytes = files::read_file(file, 64 * files::kMegabyte).value();
  Loss out;
  std::map<std::string, std::int64_t> last;
  std::map<std::string, std::uint32_t> sequence;
  const auto content = recording::scan_mcap(
      bytes, file, [&](const recording::McapChannel& channel, const recording::McapMessage& m) {
        if (channel.topic == topics::state) return;  // what the recorder says of itself
        const auto at =
            std::lower_bound(said.time_ns, said.time_ns + said.rounds.load() + 1, m.log_ns) - said.time_ns;
        std::int64_t& before = last.try_emplace(channel.topic, at - 1).first->second;
        out.not_received += static_cast<std::uint64_t>(at - before - 1);
        before = at;
        std::uint32_t& next = sequence.try_emplace(channel.topic, m.sequence).first->second;
        out.gaps += static_cast<std::uint64_t>(m.sequence != next);
        next = m.sequence + 1;
      });
  EXPECT_TRUE(content) << content.error().text();
  EXPECT_EQ(last.size(), 5u);
  for (const auto& [topic, at] : last)
    if (const auto first_lost = static_cast<std::size_t>(at + 1); first_lost < rounds)
      out.ms = std::max(out.ms, 1e-6 * static_cast<double>(killed_ns - said.time_ns[first_lost]));
  return out;
}

/// Whether every one of the five topics is in the file.
bool has_begun(const fs::path& file) {
  const auto bytes = files::read_file(file, 64 * files::kMegabyte);
  std::set<std::string> heard;
  if (bytes)
    (void)recording::scan_mcap(*bytes, file,
                               [&](const recording::McapChannel& channel, const recording::McapMessage&) {
                                 if (channel.topic != topics::state) heard.insert(channel.topic);
                               });
  return heard.size() == 5;
}

TEST(RecorderKill, LosesAtMostATenthOfASecondAndLeavesNoGap) {
  const fs::path folder = fs::temp_directory_path() / ("omniflight_recorder_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const auto claim = bus::claim_free_domain(101, 150);
  ASSERT_TRUE(claim) << claim.error().text();
  void* memory = ::mmap(nullptr, sizeof(Said), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto& said = *static_cast<Said*>(memory);
  const pid_t publisher = ::fork();
  if (publisher == 0) say(claim->domain(), said);
  std::mt19937_64 random(11);
  std::vector<double> losses;
  std::uint64_t gaps = 0, not_received = 0;
  for (int k = 0; k < kills(); ++k) {
    const fs::path file = folder / (std::to_string(k) + ".mcap");
    const pid_t recorder = ::fork();
    if (recorder == 0) record(claim->domain(), file);
    for (const auto end = std::chrono::steady_clock::now() + 20s;
         !has_begun(file) && std::chrono::steady_clock::now() < end;)
      std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(std::chrono::microseconds(20'000 + random() % 400'000));
    const std::size_t rounds = said.rounds;
    const std::int64_t killed = now_ns();
    ::kill(recorder, SIGKILL);
    int status = 0;
    ::waitpid(recorder, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    const Loss loss = loss_of(file, said, rounds, killed);
    losses.push_back(loss.ms);
    gaps += loss.gaps;
    not_received += loss.not_received;
    fs::remove(file);
  }
  ::kill(publisher, SIGKILL);
  ::waitpid(publisher, nullptr, 0);
  std::sort(losses.begin(), losses.end());
  std::printf(
      "%zu kills of the recorder at 5 topics x 1 kHz: lost %.1f ms in the median, %.1f ms at worst, "
      "%llu gaps; %llu messages were not delivered to it\n",
      losses.size(), losses[losses.size() / 2], losses.back(), static_cast<unsigned long long>(gaps),
      static_cast<unsigned long long>(not_received));
  EXPECT_LE(losses.back(), kPromise_ms);
  EXPECT_GT(losses.back(), 0.0);
  EXPECT_EQ(gaps, 0u);
  ::munmap(memory, sizeof(Said));
  fs::remove_all(folder);
}

}  // namespace
