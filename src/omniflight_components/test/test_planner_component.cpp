// A mission that comes in flight: planned from the state to come, joined without a jump, flown to its goal.
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "lockstep_flight.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_core/frames.hpp"

namespace {

using namespace omniflight;
using msgs::omniflight_msgs::ControllerState;
using msgs::omniflight_msgs::TruthState;
using msgs::std_msgs::String;
using TrajectoryMessage = msgs::trajectory_msgs::MultiDOFJointTrajectory;
namespace fs = std::filesystem;

constexpr auto kLongest = std::chrono::seconds(30);  // that flight time stands still for planning

struct Heard {
  int trajectories = 0;
  double asked_at = 0, largest_step = 0, largest_change = 0;  // s; m; m/s^2
  bool moving = false;                                        // when the new plan began
  Vec3 reference = Vec3::Zero(), truth = Vec3::Zero();
};

/// Asks for a mission once the plan is followed since `at` [s]. Flight time stands still until the planner
/// has answered, so that nothing depends on how fast the machine is.
class Asking final : public bus::Component {
 public:
  Asking(Heard& heard, double at, std::vector<std::string> missions)
      : Component("asking"), heard_(heard), at_(at), missions_(std::move(missions)) {}

 private:
  Status on_configure(const YAML::Node&) override {
    auto out = advertise<String>(components::topics::mission, bus::Qos::bulk(4));
    if (!out) return Failure(out.error());
    publisher_.emplace(std::move(*out));
    auto trajectories = bus::Subscription<TrajectoryMessage>::create(
        participant(), components::topics::trajectory, bus::Qos::latched_last(),
        [this](const TrajectoryMessage&, std::int64_t) {
          const std::lock_guard lock(mutex_);
          ++heard_.trajectories;
          answered_.notify_all();
        });
    if (!trajectories) return Failure(trajectories.error());
    trajectories_.emplace(std::move(*trajectories));
    auto truths = bus::Subscription<TruthState>::create(
        participant(), components::topics::truth, bus::Qos::bulk(512),
        [this](const TruthState& m, std::int64_t) {
          heard_.truth = Vec3(m.position[0], m.position[1], m.position[2]);
        });
    if (!truths) return Failure(truths.error());
    truths_.emplace(std::move(*truths));
    auto states = bus::Subscription<ControllerState>::create(
        participant(), components::topics::controller, bus::Qos::bulk(512),
        [this](const ControllerState& m, std::int64_t) { follow(m); });
    if (!states) return Failure(states.error());
    states_.emplace(std::move(*states));
    return {};
  }
  Status on_cleanup() override {
    states_.reset();
    truths_.reset();
    trajectories_.reset();
    publisher_.reset();
    return {};
  }

  void follow(const ControllerState& m) {
    const Vec3 p(m.ref_position[0], m.ref_position[1], m.ref_position[2]);
    const Vec3 a(m.ref_acceleration[0], m.ref_acceleration[1], m.ref_acceleration[2]);
    if (m.trajectory_time > 0 && known_) {
      heard_.largest_step = std::max(heard_.largest_step, (p - heard_.reference).norm());
      heard_.largest_change = std::max(heard_.largest_change, (a - acceleration_).norm());
    }
    if (asked_ && m.trajectory_time < heard_.asked_at + 2.05 && m.trajectory_time > heard_.asked_at + 1.95)
      heard_.moving = heard_.moving || (p - heard_.reference).norm() > 1e-4;
    heard_.reference = p, acceleration_ = a, known_ = true;
    if (asked_ || m.trajectory_time < at_) return;
    asked_ = true;
    heard_.asked_at = m.trajectory_time;
    for (const std::string& mission : missions_) {
      bus::set_text(message_->data, mission.c_str());
      (void)publisher_->publish(*message_, 0);
      std::unique_lock lock(mutex_);
      const int before = heard_.trajectories;
      // a mission that has no plan is not answered with a trajectory
      answered_.wait_for(lock, &mission == &missions_.back() ? kLongest : std::chrono::seconds(3),
                         [&] { return heard_.trajectories > before; });
    }
  }

  Heard& heard_;
  double at_;
  std::vector<std::string> missions_;
  bool asked_ = false, known_ = false;
  Vec3 acceleration_ = Vec3::Zero();
  std::mutex mutex_;
  std::condition_variable answered_;
  bus::Message<String> message_;
  std::optional<bus::Publisher<String>> publisher_;
  std::optional<bus::Subscription<TrajectoryMessage>> trajectories_;
  std::optional<bus::Subscription<ControllerState>> states_;
  std::optional<bus::Subscription<TruthState>> truths_;
};

std::string mission_to(const std::string& name, const std::string& position) {
  const fs::path file = fs::path(testing::TempDir()) / ("in_flight_" + name + ".yaml");
  std::ofstream(file) << "schema: omniflight.mission/1\nname: " << name
                      << "\nvehicle: omnimorph\ntest_bed: pyramid\nalpha_deg: 30\nclearance_m: 0.05\n"
                         "budget_ms: 20000\nstart: {position: [0, 0, 1.3]}\nwaypoints:\n  - {position: "
                      << position << "}\n";
  return file.string();
}

Heard flown(double at, double duration, std::vector<std::string> missions) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  Heard heard;
  const fs::path replans = fs::path(testing::TempDir()) / "replans";
  fs::remove_all(replans);
  const auto claim = bus::claim_free_domain();
  EXPECT_TRUE(claim);
  if (!claim) return heard;
  auto options = components::test::lockstep_flight(
      claim->domain(), duration,
      {"planner:replan_lead_s:=2", "planner:replans:=" + replans.string(), "simulator:command_timeout_s:=60",
       "simulator:initial_position_m:=[0, 0, 1.3]"});
  options.timeout = std::chrono::seconds(100);
  std::vector<std::unique_ptr<bus::Component>> parts;
  for (const char* name : {"planner", "allocator", "controller"})
    parts.push_back(components::make_component(name));
  parts.push_back(std::make_unique<Asking>(heard, at, std::move(missions)));
  parts.push_back(components::make_component("simulator"));
  EXPECT_EQ(bus::run_components(std::move(parts), options), 0);
  return heard;
}

// trajectory_1 holds for 5 s, then goes aside
TEST(PlannerComponent, AMissionInFlightIsJoinedWhileTheOldPlanMoves) {
  const Heard heard =
      flown(3.6, 20.0, {mission_to("far", "[300, 0, 1.2]"), mission_to("near", "[0.2, 0.1, 1.2]")});
  EXPECT_EQ(heard.trajectories, 2) << "the one that has no plan changes nothing";
  EXPECT_TRUE(heard.moving);
  EXPECT_NEAR((heard.reference - Vec3(0.2, 0.1, 1.2)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((heard.truth - Vec3(0.2, 0.1, 1.2)).norm(), 0.0, 0.05);
  EXPECT_LT(heard.largest_step, 0.002 * 0.6) << "the reference jumps";  // m in a control period
  EXPECT_LT(heard.largest_change, 0.1) << "the acceleration jumps";
  EXPECT_TRUE(fs::exists(fs::path(testing::TempDir()) / "replans/1/certificate.json"));
}

}  // namespace
