// Boards that are commanded by somebody with a clock of his own: emulated boards, gateway and a commander in
// one process, in real time.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"

namespace {

using namespace omniflight;
using namespace msgs;
namespace fs = std::filesystem;
namespace topics = components::topics;

constexpr double kSpeed = 100.0;  // rad/s, well below hover
constexpr double kUnix = 1.7e9;   // s
constexpr double kFlight = 1.5;   // s

/// An operator's wish, so long after the first tick.
struct Wish {
  std::chrono::milliseconds after;
  const char* words;
};

/// Answers every tick with one speed for all rotors, stamped as `clock` says of flight time [s]; without a
/// clock it answers none. Says what an operator may say, too.
class Commander final : public bus::Component {
 public:
  using Clock = std::function<double(double t, double in_flight_s)>;
  Commander(Clock clock, std::vector<Wish> wishes, std::atomic<double>& fastest)
      : Component("commander"), clock_(std::move(clock)), wishes_(std::move(wishes)), fastest_(fastest) {}

 private:
  Status on_configure(const YAML::Node&) override {
    auto commands = advertise<actuator_msgs::Actuators>(topics::command, bus::Qos::bulk(64));
    if (!commands) return Failure(commands.error());
    commands_.emplace(std::move(*commands));
    auto wish = advertise<std_msgs::String>(topics::wish, bus::Qos::latched_last(4));
    if (!wish) return Failure(wish.error());
    wish_.emplace(std::move(*wish));
    auto truth = bus::Subscription<omniflight_msgs::TruthState>::create(
        participant(), topics::truth, bus::Qos::bulk(64), [this](const auto& m, std::int64_t) {
          for (const double w : bus::view(m.rotor_velocity))
            fastest_ = std::max(fastest_.load(), std::abs(w));
          say();
        });
    if (!truth) return Failure(truth.error());
    truth_.emplace(std::move(*truth));
    auto tick = bus::Subscription<omniflight_msgs::Tick>::create(
        participant(), topics::tick, bus::Qos::bulk(64), [this](const auto& m, std::int64_t) {
          const double t = 1e-9 * static_cast<double>(bus::nanoseconds(m.header.stamp));
          if (m.phase == omniflight_msgs::Tick_PHASE_HELD) free_since_ = t;
          if (!began_.load()) begin_ = std::chrono::steady_clock::now(), began_ = true;
          if (!clock_) return;
          const double stamp_s = clock_(t, t - free_since_);
          command_->header.stamp = bus::stamp(std::llround(stamp_s * 1e9));
          const std::array<double, 8> speeds{kSpeed, kSpeed, kSpeed, kSpeed, kSpeed, kSpeed, kSpeed, kSpeed};
          bus::assign(command_->velocity, speeds);
          (void)commands_->publish(*command_, 1);
        });
    if (!tick) return Failure(tick.error());
    tick_.emplace(std::move(*tick));
    return {};
  }
  Status on_cleanup() override {
    tick_.reset();
    truth_.reset();
    commands_.reset();
    wish_.reset();
    return {};
  }

  /// From the thread of the truth, which goes on when the ticks have ended.
  void say() {
    while (began_.load() && next_ < wishes_.size() &&
           std::chrono::steady_clock::now() - begin_ >= wishes_[next_].after) {
      bus::set_text(wish_message_->data, wishes_[next_++].words);
      (void)wish_->publish(*wish_message_, 1);
    }
  }

  Clock clock_;
  std::vector<Wish> wishes_;
  std::size_t next_ = 0;
  std::chrono::steady_clock::time_point begin_;
  std::atomic<bool> began_{false};
  bus::Message<std_msgs::String> wish_message_;
  std::optional<bus::Publisher<std_msgs::String>> wish_;
  std::atomic<double>& fastest_;
  double free_since_ = 0;
  bus::Message<actuator_msgs::Actuators> command_;
  std::optional<bus::Publisher<actuator_msgs::Actuators>> commands_;
  std::optional<bus::Subscription<omniflight_msgs::TruthState>> truth_;
  std::optional<bus::Subscription<omniflight_msgs::Tick>> tick_;
};

struct Flown {
  int code;
  std::string text;
  double fastest;  ///< rad/s
  double wall_s;   ///< of everything
};

Flown fly(Commander::Clock clock, std::vector<Wish> wishes = {}, const std::string& more = "") {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const fs::path folder = fs::temp_directory_path() / ("omniflight_commander_" + std::to_string(::getpid()));
  const auto claim = bus::claim_free_domain();
  if (!claim) return {-1, claim.error().text(), 0, 0};
  const auto epoch = std::chrono::steady_clock::now().time_since_epoch();
  const std::string epoch_ns = std::to_string(std::chrono::nanoseconds(epoch).count());
  const std::string board = folder.string() + "/board";
  bus::RunOptions options;
  options.domain = claim->domain();
  options.loopback_file = OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml";
  options.overrides = {"emulator:vehicle:=omnimorph",
                       "emulator:link_directory:=" + folder.string(),
                       "emulator:epoch_monotonic_ns:=" + epoch_ns,
                       "gateway:vehicle:=omnimorph",
                       "gateway:devices:=" + board + "0;" + board + "1;" + board + "2",
                       "gateway:epoch_monotonic_ns:=" + epoch_ns,
                       "gateway:require_recorder:=false",
                       "gateway:least_free_MB:=0",
                       "gateway:most_missed_share:=1",
                       "gateway:hold_s:=0.5",
                       "gateway:flight_s:=" + std::to_string(kFlight),
                       "gateway:stale_after_s:=1.0",  // a busy machine is no other clock
                       "gateway:board_silence_s:=1.5",
                       "gateway:board_stall_s:=1.5"};
  if (!more.empty()) options.overrides.push_back(more);
  options.timeout = std::chrono::seconds(60);
  std::atomic<double> fastest{0};
  std::vector<std::unique_ptr<bus::Component>> parts;
  parts.push_back(std::make_unique<Commander>(std::move(clock), std::move(wishes), fastest));
  parts.push_back(components::make_component("emulator"));
  parts.push_back(components::make_component("gateway"));
  ::testing::internal::CaptureStderr();
  const int code = bus::run_components(std::move(parts), options);
  std::error_code ec;
  fs::remove_all(folder, ec);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now().time_since_epoch() - epoch;
  return {code, ::testing::internal::GetCapturedStderr(), fastest.load(), wall.count()};
}

#define EXPECT_SAYS(flown, words) EXPECT_NE(flown.text.find(words), std::string::npos) << flown.text

TEST(ForeignCommander, CommandsInUnixTimeAreFlownWith) {
  const Flown flown = fly([](double t, double) { return kUnix + t; });
  EXPECT_EQ(flown.code, 0) << flown.text;
  EXPECT_GT(flown.fastest, 0.9 * kSpeed);
  EXPECT_SAYS(flown, "[gateway] commands: another clock is followed, 1.7e+09 s from flight time");
}

TEST(ForeignCommander, OneFutureStampBlindsNobody) {
  for (const double base : {0.0, kUnix}) {
    bool told = false;
    const Flown flown = fly([&](double t, double in_flight_s) {
      return base + t + (in_flight_s > 0.5 && !std::exchange(told, true) ? 5.0 : 0.0);
    });
    EXPECT_EQ(flown.code, 0) << flown.text;
    EXPECT_SAYS(flown, "commands refused, the last: stamp 5 s ahead of flight time");
  }
}

TEST(ForeignCommander, AClockThatJumpsEndsInTheRamp) {
  const Flown flown =
      fly([](double t, double in_flight_s) { return kUnix + t + (in_flight_s > 0.5 ? 5.0 * t : 0.0); });
  EXPECT_EQ(flown.code, static_cast<int>(ErrorCode::incomplete)) << flown.text;
  EXPECT_SAYS(flown, "ahead of flight time");
  EXPECT_SAYS(flown, "the safety gate stopped the rotors: stale_command");
}

constexpr auto own_clock = [](double t, double) { return t; };

TEST(ForeignCommander, AStopIsNotTakenBackByWhatIsSaidBeforeItIsObeyed) {
  using namespace std::chrono_literals;
  for (const auto& [first, second, reason] : {std::tuple{"cut", "none", "emergency_stop"},
                                              {"cut", "stop", "emergency_stop"},
                                              {"stop", "hold", "requested"}}) {
    const Flown flown = fly(own_clock, {{1s, first}, {1s, second}});
    EXPECT_EQ(flown.code, static_cast<int>(ErrorCode::incomplete)) << flown.text;
    EXPECT_SAYS(flown, std::string("the safety gate stopped the rotors: ") + reason);
  }
}

/// Flight time [s] at which the gate came into a state, from what it says.
double gate_at(const Flown& flown, const std::string& state) {
  const auto at = flown.text.find(" at ", flown.text.find("gate " + state));
  return at == std::string::npos ? NAN : std::stod(flown.text.substr(at + 4));
}

TEST(ForeignCommander, AnEmergencyStopEndsTheRamp) {
  using namespace std::chrono_literals;
  const Flown flown = fly(own_clock, {{1s, "stop"}, {1500ms, "cut"}}, "gateway:ramp_s:=5");
  EXPECT_EQ(flown.code, static_cast<int>(ErrorCode::incomplete)) << flown.text;
  const double ramp_s = gate_at(flown, "stopped") - gate_at(flown, "ramping");
  EXPECT_GT(ramp_s, 0.2) << flown.text;
  EXPECT_LT(ramp_s, 1.5) << flown.text;
}

TEST(ForeignCommander, AStopNeedsNoCommand) {
  using namespace std::chrono_literals;
  for (const char* wish : {"cut", "stop"}) {
    const Flown flown = fly({}, {{300ms, wish}});
    EXPECT_EQ(flown.code, static_cast<int>(ErrorCode::incomplete)) << flown.text;
    EXPECT_SAYS(flown, "the operator stopped it before the flight began");
    EXPECT_LT(flown.wall_s, 15) << "motors idle until commands are given up";
  }
}

}  // namespace
