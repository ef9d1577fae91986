// A flight with somebody who spoils it: all components in one process, in lockstep, so that a time is exact
// to one control period. Include in one source of a test program.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_core/frames.hpp"

namespace {

using namespace omniflight;
using namespace msgs;
namespace fs = std::filesystem;
namespace topics = components::topics;

constexpr double kPeriod = 0.002;  // s, control period

/// Watches a flight, and at every tick may publish poses and commands of its own.
class Stranger final : public bus::Component {
 public:
  using Act = std::function<void(Stranger&, double t)>;
  explicit Stranger(Act act) : Component("stranger"), act_(std::move(act)) {}

  void pose(double stamp_s, double x) {
    pose_->header.stamp = bus::stamp(std::llround(stamp_s * 1e9));
    pose_->pose.position.x = x;
    pose_->pose.position.z = 1.3;
    pose_->pose.orientation.w = 1.0;
    (void)poses_->publish(*pose_, 1);
  }
  void command(double stamp_s, double speed) {
    command_->header.stamp = bus::stamp(std::llround(stamp_s * 1e9));
    const std::array<double, 8> speeds{speed, speed, speed, speed, speed, speed, speed, speed};
    bus::assign(command_->velocity, speeds);
    (void)commands_->publish(*command_, 1);
  }

  /// Plays the motion capture in place of the plant's: the true pose of latency_s ago at 250 Hz, stamped as
  /// `clock` says of that time.
  void play_mocap(std::function<double(double t)> clock, double latency_s = 0.008) {
    mocap_clock_ = std::move(clock);
    latency_s_ = latency_s;
  }

  /// Plays the inertial sensor in place of the plant's, once a control period.
  void play_imu(std::function<double(double t)> clock) { imu_clock_ = std::move(clock); }

  void wish(const char* words) {
    bus::set_text(wish_message_->data, words);
    (void)wishes_->publish(*wish_message_, 1);
  }

  std::function<double(double t)> outlier_m;  ///< added to y of the poses that are played
  std::optional<double> first_word_s;         ///< stamp of a command before the first tick
  double furthest_m = 0;  ///< of the true position from where the flight began, while it is free
  double sideways_m = 0;  ///< largest |y| of the same
  double end_s = 0;
  struct Said {
    double t;
    std::string words;
  };
  std::vector<Said> failsafe;
  Vec3 last = Vec3::Zero(), first = Vec3::Constant(NAN);

 private:
  template <class T>
  Status hear(std::optional<bus::Subscription<T>>& slot, const char* topic, const bus::Qos& qos,
              std::function<void(const T&)> take) {
    auto made = bus::Subscription<T>::create(participant(), topic, qos,
                                             [take](const T& m, std::int64_t) { take(m); });
    if (!made) return Failure(made.error());
    slot.emplace(std::move(*made));
    return {};
  }
  Status on_configure(const YAML::Node&) override {
    auto poses = advertise<geometry_msgs::PoseStamped>(topics::mocap, bus::Qos::bulk(64));
    if (!poses) return Failure(poses.error());
    poses_.emplace(std::move(*poses));
    auto imus = advertise<sensor_msgs::Imu>(topics::imu, bus::Qos::bulk(64));
    if (!imus) return Failure(imus.error());
    imus_.emplace(std::move(*imus));
    auto commands = advertise<actuator_msgs::Actuators>(topics::command, bus::Qos::bulk(64));
    if (!commands) return Failure(commands.error());
    commands_.emplace(std::move(*commands));
    auto wishes = advertise<std_msgs::String>(topics::wish, bus::Qos::latched_last());
    if (!wishes) return Failure(wishes.error());
    wishes_.emplace(std::move(*wishes));
    Status ok =
        hear<omniflight_msgs::TruthState>(truth_, topics::truth, bus::Qos::bulk(64), [this](const auto& m) {
          last = Vec3(m.position[0], m.position[1], m.position[2]);
          if (!first.allFinite()) first = last;
          furthest_m = std::max(furthest_m, (last - first).norm());
          sideways_m = std::max(sideways_m, std::abs((last - first).y()));
          if (const auto stamp_s = std::exchange(first_word_s, std::nullopt)) command(*stamp_s, 0.0);
          relay(m);
          measure(m);
        });
    if (ok)
      ok = hear<diagnostic_msgs::DiagnosticArray>(
          failsafe_, topics::failsafe, bus::Qos::latched_last(), [this](const auto& m) {
            failsafe.push_back({1e-9 * static_cast<double>(bus::nanoseconds(m.header.stamp)),
                                std::string(bus::text(bus::view(m.status)[0].message))});
          });
    if (ok)
      ok = hear<omniflight_msgs::Tick>(tick_, topics::tick, bus::Qos::bulk(64), [this](const auto& m) {
        end_s = 1e-9 * static_cast<double>(bus::nanoseconds(m.header.stamp));
        if (act_) act_(*this, end_s);
      });
    return ok;
  }
  Status on_cleanup() override {
    tick_.reset();
    failsafe_.reset();
    truth_.reset();
    poses_.reset();
    imus_.reset();
    wishes_.reset();
    commands_.reset();
    return {};
  }

  void measure(const omniflight_msgs::TruthState& m) {
    const double t = 1e-9 * static_cast<double>(bus::nanoseconds(m.header.stamp));
    const Vec3 v(m.velocity[0], m.velocity[1], m.velocity[2]);
    if (imu_clock_ && velocity_) {
      const Quat q(m.attitude[0], m.attitude[1], m.attitude[2], m.attitude[3]);
      const Vec3 f = q.conjugate() * ((v - *velocity_) / kPeriod + Vec3(0, 0, kGravity));
      imu_->header.stamp = bus::stamp(std::llround(imu_clock_(t) * 1e9));
      imu_->linear_acceleration = {f.x(), f.y(), f.z()};
      imu_->angular_velocity = {m.angular_velocity[0], m.angular_velocity[1], m.angular_velocity[2]};
      (void)imus_->publish(*imu_, 1);
    }
    velocity_ = v;
  }
  void relay(const omniflight_msgs::TruthState& m) {
    if (!mocap_clock_) return;
    const double t = 1e-9 * static_cast<double>(bus::nanoseconds(m.header.stamp));
    if (++truths_ % 2 == 0) in_flight_.emplace_back(t, Seen(m));
    while (!in_flight_.empty() && in_flight_.front().first <= t - latency_s_) {
      const auto& [taken, state] = in_flight_.front();
      pose_->header.stamp = bus::stamp(std::llround(mocap_clock_(taken) * 1e9));
      pose_->pose.position = {state.position[0], state.position[1], state.position[2]};
      const double* q = state.attitude;  // w x y z
      pose_->pose.orientation = {q[1], q[2], q[3], q[0]};
      if (outlier_m) pose_->pose.position.y += outlier_m(taken);
      (void)poses_->publish(*pose_, 1);
      in_flight_.pop_front();
    }
  }

  Act act_;
  std::function<double(double)> mocap_clock_, imu_clock_;
  std::optional<Vec3> velocity_;  ///< m/s, of the truth before
  bus::Message<sensor_msgs::Imu> imu_;
  std::optional<bus::Publisher<sensor_msgs::Imu>> imus_;
  double latency_s_ = 0;
  std::uint64_t truths_ = 0;
  struct Seen {
    double position[3], attitude[4];
    explicit Seen(const omniflight_msgs::TruthState& m) {
      std::copy_n(m.position, 3, position);
      std::copy_n(m.attitude, 4, attitude);
    }
  };
  std::deque<std::pair<double, Seen>> in_flight_;
  bus::Message<geometry_msgs::PoseStamped> pose_;
  bus::Message<actuator_msgs::Actuators> command_;
  bus::Message<std_msgs::String> wish_message_;
  std::optional<bus::Publisher<std_msgs::String>> wishes_;
  std::optional<bus::Publisher<geometry_msgs::PoseStamped>> poses_;
  std::optional<bus::Publisher<actuator_msgs::Actuators>> commands_;
  std::optional<bus::Subscription<omniflight_msgs::TruthState>> truth_;
  std::optional<bus::Subscription<diagnostic_msgs::DiagnosticArray>> failsafe_;
  std::optional<bus::Subscription<omniflight_msgs::Tick>> tick_;
};

class FailsafeFlight : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "short.yaml")
        << "schema: omniflight.mission/1\nname: short\nvehicle: omnimorph\ntest_bed: pyramid\nalpha_deg: 30\n"
           "clearance_m: 0.08\nseed: 1\nbudget_ms: 1000\n"
           "limits: {speed_mps: 0.3, acceleration_mps2: 0.4, rate_dps: 30, angular_acceleration_dps2: 90, "
           "rotor_headroom: 0.1}\n"
           "start: {position: [0, 0, 1.3], attitude: {rpy_deg: [0, 0, 0]}, hold_s: 0.5}\n"
           "waypoints:\n  - {name: aside, by: [0.05, 0, 0], hold_s: 0.5}\n";
    claim_.emplace(bus::claim_free_domain());
    ASSERT_TRUE(*claim_) << claim_->error().text();
  }
  void TearDown() override { fs::remove_all(folder_); }

  struct Flown {
    int code;
    std::string text;  ///< stderr
    std::shared_ptr<Stranger> seen;
  };
  /// 8 s of simulated flight with the stranger beside it; the faults, when there are any, as YAML list items.
  Flown fly(Stranger::Act act, const std::string& faults = "", double duration_s = 8,
            const std::vector<std::string>& parameters = {},
            const std::function<void(Stranger&)>& prepare = {}) {
    std::vector<std::string> overrides{"planner:mission:=" + (folder_ / "short.yaml").string(),
                                       "allocator:vehicle:=omnimorph",
                                       "simulator:vehicle:=omnimorph",
                                       "simulator:initial_position_m:=[0, 0, 1.3]",
                                       "simulator:initial_alpha_deg:=30",
                                       "simulator:sensors:=" OMNIFLIGHT_SOURCE_ROOT
                                       "/configs/sensors/laboratory.yaml",
                                       "simulator:duration_s:=" + std::to_string(duration_s)};
    if (!faults.empty()) {
      std::ofstream(folder_ / "faults.yaml") << "schema: omniflight.faults/1\nfaults:\n" << faults;
      overrides.push_back("simulator:faults_file:=" + (folder_ / "faults.yaml").string());
    }
    overrides.insert(overrides.end(), parameters.begin(), parameters.end());
    std::vector<std::unique_ptr<bus::Component>> parts;
    for (const char* name : {"planner", "allocator", "controller"})
      parts.push_back(components::make_component(name));
    auto stranger = std::make_unique<Stranger>(std::move(act));
    Stranger* seen = stranger.get();
    if (prepare) prepare(*seen);
    auto kept = std::make_shared<Stranger>(Stranger::Act{});
    parts.push_back(std::move(stranger));
    parts.push_back(std::make_unique<Keeper>(*seen, kept));
    parts.push_back(components::make_component("simulator"));
    bus::RunOptions options;
    options.domain = (*claim_)->domain();
    options.loopback_file = OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml";
    options.overrides = overrides;
    options.timeout = std::chrono::seconds(60);
    ::testing::internal::CaptureStderr();
    const int code = bus::run_components(std::move(parts), options);
    return {code, ::testing::internal::GetCapturedStderr(), kept};
  }

  /// What the ladder did, as "action: cause" in their order.
  static std::string story(const Flown& flown) {
    std::string out;
    for (const auto& said : flown.seen->failsafe) out += (out.empty() ? "" : ", ") + said.words;
    return out;
  }

  /// Keeps what a component saw beyond its end.
  class Keeper final : public bus::Component {
   public:
    Keeper(Stranger& from, std::shared_ptr<Stranger> to)
        : Component("keeper"), from_(from), to_(std::move(to)) {}

   private:
    Status on_configure(const YAML::Node&) override { return {}; }
    Status on_deactivate() override {
      to_->furthest_m = from_.furthest_m;
      to_->sideways_m = from_.sideways_m;
      to_->end_s = from_.end_s;
      to_->failsafe = from_.failsafe;
      to_->last = from_.last;
      to_->first = from_.first;
      return {};
    }
    Stranger& from_;
    std::shared_ptr<Stranger> to_;
  };

  fs::path folder_ = fs::temp_directory_path() / ("omniflight_failsafe_" + std::to_string(::getpid()));
  std::optional<Result<bus::DomainClaim>> claim_;
};

constexpr int kIncomplete = static_cast<int>(ErrorCode::incomplete);
/// m that a quiet flight of this mission moves away from where it begins.
constexpr double kQuietFlight = 0.15;

#define EXPECT_SAYS(flown, words) EXPECT_NE(flown.text.find(words), std::string::npos) << flown.text

}  // namespace
