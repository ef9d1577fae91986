// Every folder of behaviours/ is a flight: what happens when, and what the ladder is to do then.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <omniflight_files/yaml.hpp>

#include "omniflight_safety/vitals.hpp"

namespace omniflight::safety {
namespace {

namespace fs = std::filesystem;

constexpr double kStep = 0.002;   // s, control period
constexpr double kForever = 1e9;  // s
constexpr std::size_t kLeastBehaviours = 27;

fs::path folder() { return fs::path(OMNIFLIGHT_SOURCE_ROOT) / "src/omniflight_safety/test/behaviours"; }

std::vector<std::string> names() {
  std::vector<std::string> out;
  for (const auto& entry : fs::directory_iterator(folder())) out.push_back(entry.path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

/// One line of `events`: what is different from normal while it lasts.
struct Event {
  double at = 0, until = kForever, every = 0, lasts = kForever;
  bool pose = true, imu = true, commands = true, recorder = true, planner = true, boards = true, clock = true;
  bool emergency = false, on_ground = false, nowhere = false;
  double innovation = 0, missed = 0, hover_load = 0;
  std::optional<double> battery;
  std::optional<Vec3> position;
  Wish wish = Wish::none;

  bool active(double t) const {
    if (t < at || t >= until) return false;
    return every <= 0 || std::fmod(t - at, every) < lasts;
  }
};

Event read_event(files::YamlReader y) {
  Event e;
  const auto s = files::non_negative("s");
  e.at = y.number("at_s", s);
  e.until = y.number("until_s", s, kForever);
  e.every = y.number("every_s", s, 0.0);
  e.lasts = y.number("for_s", s, kForever);
  e.pose = y.boolean("pose", true);
  e.imu = y.boolean("imu", true);
  e.commands = y.boolean("commands", true);
  e.recorder = y.boolean("recorder", true);
  e.planner = y.boolean("planner", true);
  e.boards = y.boolean("boards", true);
  e.clock = y.boolean("clock", true);
  e.emergency = y.boolean("emergency", false);
  e.on_ground = y.boolean("on_ground", false);
  e.nowhere = y.boolean("position_is_no_number", false);
  e.innovation = y.number("innovation_m", files::non_negative("m"), 0.0);
  e.missed = y.number("missed_share", files::between(0, 1), 0.0);
  e.hover_load = y.number("hover_load", files::between(0, 100), 0.0);
  if (y.has("battery_V")) e.battery = y.number("battery_V", files::positive("V"));
  if (y.has("position_m")) e.position = y.vec3("position_m", files::any_number("m"));
  e.wish = y.choice<Wish>("wish",
                          {{"none", Wish::none},
                           {"hold", Wish::hold},
                           {"land", Wish::land},
                           {"stop", Wish::stop},
                           {"cut", Wish::cut}},
                          Wish::none);
  return e;
}

struct Expected {
  double from = 0, to = 0;
  Action action = Action::fly;
};

Expected read_expected(files::YamlReader y) {
  Expected e;
  e.from = y.number("from_s", files::non_negative("s"));
  e.to = y.number("to_s", files::non_negative("s"));
  e.action = y.choice<Action>("action", {{"fly", Action::fly},
                                         {"hold", Action::hold},
                                         {"descend", Action::descend},
                                         {"ramp_down", Action::ramp_down},
                                         {"off", Action::off}});
  return e;
}

/// The vitals of a flight at time t; `ages` are the times since pose, IMU and command last came.
struct Flight {
  double pose_s = 0, imu_s = 0, command_s = 0;

  Vitals at(double t, const std::vector<Event>& events, bool& on_ground) {
    Vitals v;
    v.p_W = Vec3(0, 0, 1);
    v.battery_V = 15.2;
    bool pose = true, imu = true, commands = true;
    on_ground = false;
    for (const Event& e : events) {
      if (!e.active(t)) continue;
      pose = pose && e.pose;
      imu = imu && e.imu;
      commands = commands && e.commands;
      v.recorder = v.recorder && e.recorder;
      v.planner = v.planner && e.planner;
      v.boards = v.boards && e.boards;
      v.clock = v.clock && e.clock;
      v.board_emergency = v.board_emergency || e.emergency;
      on_ground = on_ground || e.on_ground;
      v.innovation_m = std::max(v.innovation_m, e.innovation);
      v.missed_share = std::max(v.missed_share, e.missed);
      v.hover_load = std::max(v.hover_load, e.hover_load);
      if (e.battery) v.battery_V = e.battery;
      if (e.position) v.p_W = e.position;
      if (e.nowhere) v.p_W = Vec3::Constant(std::nan(""));
      v.wish = std::max(v.wish, e.wish);
    }
    if (pose) pose_s = t;
    if (imu) imu_s = t;
    if (commands) command_s = t;
    v.pose_age_s = t - pose_s;
    v.imu_age_s = t - imu_s;
    v.command_age_s = t - command_s;
    return v;
  }
};

Limits limits() {
  Limits l;
  l.command_stale_s = 0.015;
  l.battery_low_V = 14.0;
  l.battery_empty_V = 13.0;
  l.fence = {Vec3(-3.6, -3.6, -0.1), Vec3(3.6, 3.6, 4.0), 0.5};
  return l;
}

class Behaviour : public testing::TestWithParam<std::string> {};

TEST_P(Behaviour, IsAsItsFolderSays) {
  auto root = files::YamlReader::load(folder() / GetParam() / "behaviour.yaml");
  ASSERT_TRUE(root) << root.error().text();
  ASSERT_EQ(root->string("schema"), "omniflight.behaviour/1");
  std::vector<Event> events;
  std::vector<Expected> expected;
  for (auto& y : root->children("events")) events.push_back(read_event(y));
  for (auto& y : root->children("expect", 1)) expected.push_back(read_expected(y));
  const auto read = root->finish();
  ASSERT_TRUE(read) << read.error().text();

  const LadderConfig config = LadderConfig::standard();
  auto state = arm(config, {}, 0.0, {});
  ASSERT_TRUE(state) << state.error().text();
  Flight flight;
  double end = 0;
  for (const Expected& e : expected) end = std::max(end, e.to);
  std::vector<std::size_t> looked(expected.size(), 0);
  for (int k = 1; k * kStep <= end; ++k) {
    const double t = k * kStep;
    bool on_ground = false;
    const Vitals vitals = flight.at(t, events, on_ground);
    *state = step(config, *state, t, judge(limits(), vitals), on_ground);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (t < expected[i].from || t > expected[i].to) continue;
      ++looked[i];
      ASSERT_EQ(to_string(state->action), to_string(expected[i].action)) << "at " << t << " s";
    }
  }
  for (const std::size_t n : looked) EXPECT_GT(n, 1u) << "an expectation that was never looked at";
}

INSTANTIATE_TEST_SUITE_P(Ladder, Behaviour, testing::ValuesIn(names()),
                         [](const auto& p) { return p.param; });

TEST(Behaviours, AreAtLeastTwentySeven) { EXPECT_GE(names().size(), kLeastBehaviours); }

}  // namespace
}  // namespace omniflight::safety
