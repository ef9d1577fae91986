// /tf of a flight: the controller's estimate in the frames of REP 105, at the rate that is asked for; and the
// joints of rotors and tilts.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "lockstep_flight.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_vehicle/robot_description.hpp"

namespace {

using namespace omniflight;
using msgs::actuator_msgs::Actuators;
using msgs::omniflight_msgs::ControllerState;
using msgs::omniflight_msgs::TruthState;
using msgs::sensor_msgs::JointState;
using msgs::tf2_msgs::TFMessage;

using Pose = std::array<double, 7>;  ///< position [m], quaternion w x y z
struct Heard {
  std::map<std::int64_t, Pose> transforms, estimates, truths;  ///< by stamp [ns]
  std::string parent, child, description;
  std::vector<std::string> joints;
  std::map<std::int64_t, std::vector<double>> speeds, commands, tilts;  ///< by stamp [ns]; of all joints
};

template <class Sequence>
std::vector<double> numbers(const Sequence& sequence) {
  const auto all = bus::view(sequence);
  return {all.begin(), all.end()};
}

Pose pose_of(const double (&p)[3], const double (&q)[4]) {
  return {p[0], p[1], p[2], q[0], q[1], q[2], q[3]};
}

class Listener final : public bus::Component {
 public:
  explicit Listener(Heard& heard) : Component("listener"), heard_(heard) {}

 private:
  template <class T, class Take>
  Status hear(std::optional<bus::Subscription<T>>& slot, const char* topic, Take take) {
    auto made = bus::Subscription<T>::create(participant(), topic, bus::Qos::bulk(512),
                                             [take](const T& m, std::int64_t) { take(m); });
    if (!made) return Failure(made.error());
    slot.emplace(std::move(*made));
    return {};
  }
  Status on_configure(const YAML::Node&) override {
    Status ok = hear<TFMessage>(transforms_, components::topics::transforms, [this](const TFMessage& m) {
      ASSERT_EQ(bus::view(m.transforms).size(), 1u);
      const auto& t = bus::view(m.transforms)[0];
      heard_.parent = bus::text(t.header.frame_id);
      heard_.child = bus::text(t.child_frame_id);
      const auto& p = t.transform.translation;
      const auto& q = t.transform.rotation;
      heard_.transforms[bus::nanoseconds(t.header.stamp)] = {p.x, p.y, p.z, q.w, q.x, q.y, q.z};
    });
    if (ok)
      ok = hear<ControllerState>(estimates_, components::topics::controller, [this](const auto& m) {
        heard_.estimates[bus::nanoseconds(m.header.stamp)] = pose_of(m.est_position, m.est_attitude);
      });
    if (ok)
      ok = hear<TruthState>(truths_, components::topics::truth, [this](const auto& m) {
        heard_.truths[bus::nanoseconds(m.header.stamp)] = pose_of(m.position, m.attitude);
      });
    if (ok)
      ok = hear<JointState>(joints_, components::topics::joints, [this](const auto& m) {
        const auto ns = bus::nanoseconds(m.header.stamp);
        heard_.speeds[ns] = numbers(m.velocity), heard_.tilts[ns] = numbers(m.position);
        heard_.joints.clear();
        for (const char* name : bus::view(m.name)) heard_.joints.emplace_back(bus::text(name));
      });
    if (ok)
      ok = hear<Actuators>(commands_, components::topics::command, [this](const auto& m) {
        heard_.commands[bus::nanoseconds(m.header.stamp)] = numbers(m.velocity);
      });
    if (ok) {
      auto made = bus::Subscription<msgs::std_msgs::String>::create(
          participant(), components::topics::robot_description, bus::Qos::latched_last(),
          [this](const auto& m, std::int64_t) { heard_.description = bus::text(m.data); });
      if (!made) return Failure(made.error());
      description_.emplace(std::move(*made));
    }
    return ok;
  }
  Status on_cleanup() override {
    joints_.reset();
    commands_.reset();
    description_.reset();
    transforms_.reset();
    estimates_.reset();
    truths_.reset();
    return {};
  }
  Heard& heard_;
  std::optional<bus::Subscription<TFMessage>> transforms_;
  std::optional<bus::Subscription<ControllerState>> estimates_;
  std::optional<bus::Subscription<TruthState>> truths_;
  std::optional<bus::Subscription<JointState>> joints_;
  std::optional<bus::Subscription<Actuators>> commands_;
  std::optional<bus::Subscription<msgs::std_msgs::String>> description_;
};

class Transforms : public ::testing::Test {
 protected:
  static constexpr double kDuration = 5.0;  // s, 1 of them held
  void SetUp() override {
    setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
    claim_.emplace(bus::claim_free_domain());
    ASSERT_TRUE(*claim_) << claim_->error().text();
  }
  Heard fly(const std::string& rate) {
    Heard heard;
    std::vector<std::unique_ptr<bus::Component>> parts;
    parts.push_back(std::make_unique<Listener>(heard));
    for (const char* name : {"planner", "allocator", "controller", "simulator"})
      parts.push_back(components::make_component(name));
    const auto options = components::test::lockstep_flight(
        (*claim_)->domain(), kDuration, {"controller:transform_hz:=" + rate, "allocator:joints_hz:=" + rate});
    EXPECT_EQ(bus::run_components(std::move(parts), options), 0);
    return heard;
  }
  std::optional<Result<bus::DomainClaim>> claim_;
};

TEST_F(Transforms, AreTheEstimatedPoseFiftyTimesASecond) {
  const Heard heard = fly("50");
  EXPECT_EQ(heard.parent, "map");
  EXPECT_EQ(heard.child, "base_link");
  EXPECT_NEAR(static_cast<double>(heard.transforms.size()), 50 * kDuration, 5);
  std::int64_t before = -1;
  for (const auto& [ns, pose] : heard.transforms) {
    if (before >= 0) {
      EXPECT_EQ(ns - before, 20'000'000);
    }
    before = ns;
    ASSERT_TRUE(heard.estimates.contains(ns));
    EXPECT_EQ(pose, heard.estimates.at(ns));
  }
  const auto truth = heard.truths.find(before);
  ASSERT_NE(truth, heard.truths.end());
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(heard.transforms.at(before)[k], truth->second[k], 0.02) << "the estimate is of this flight";
}

TEST_F(Transforms, JointsAreThoseOfTheDescriptionAsCommanded) {
  const Heard heard = fly("50");
  const auto vehicle = vehicle::load_vehicle("omnimorph").value();
  EXPECT_EQ(heard.description, vehicle::robot_description(vehicle));
  EXPECT_EQ(heard.joints, vehicle::joint_names(vehicle));
  EXPECT_NEAR(static_cast<double>(heard.speeds.size()), 50 * kDuration, 5);
  double turned = 0.0;
  for (const auto& [ns, speeds] : heard.speeds) {
    const auto command = heard.commands.find(ns);
    ASSERT_NE(command, heard.commands.end());
    ASSERT_EQ(speeds.size(), 16u);
    for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(speeds[k], command->second[k]);
    const auto& angles = heard.tilts.at(ns);
    for (std::size_t k = 9; k < 16; ++k) EXPECT_EQ(angles[k], angles[8]);  // one servo
    turned = std::max(turned, std::abs(angles[0]));
    EXPECT_LE(std::abs(angles[0]), kPi);
  }
  EXPECT_GT(turned, 1.0);
}

TEST_F(Transforms, AreNotPublishedAtRateZero) {
  const Heard heard = fly("0");
  EXPECT_TRUE(heard.speeds.empty());
  EXPECT_TRUE(heard.description.empty());
  EXPECT_TRUE(heard.transforms.empty());
  EXPECT_GT(heard.estimates.size(), 1000u);
}

}  // namespace
