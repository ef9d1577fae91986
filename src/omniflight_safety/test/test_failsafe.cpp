// Laws of the ladder that no scenario states: no forbidden transition whatever comes, anti-chatter, arming.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <omniflight_core/random.hpp>
#include <set>

#include "omniflight_safety/failsafe.hpp"

namespace omniflight::safety {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

FaultSet only(Fault fault) { return FaultSet{}.set(index(fault)); }
LadderState armed(const LadderConfig& config = LadderConfig::standard()) { return *arm(config, {}, 0.0, {}); }

/// Which action may follow which, other than by arm().
bool allowed(Action from, Action to) { return to >= from || (from == Action::hold && to == Action::fly); }

TEST(Ladder, AMillionRandomSequencesHaveNoForbiddenTransition) {
  const LadderConfig config = LadderConfig::standard();
  Random random(29, "ladder");
  constexpr int kSequences = 1'000'000, kSteps = 8;
  std::array<std::array<std::uint64_t, kActions>, kActions> seen{};
  for (int n = 0; n < kSequences; ++n) {
    LadderState s = armed(config);
    double t = 0;
    for (int k = 0; k < kSteps; ++k) {
      const std::uint64_t dice = random.next();
      t += 0.01 * static_cast<double>(dice & 0x7f);  // up to 1.27 s
      FaultSet present;
      if ((dice >> 8) & 1) present.set((dice >> 16) % kFaults);
      if (((dice >> 9) & 7) == 0) present.set((dice >> 24) % kFaults);
      const double now = ((dice >> 32) & 0x3ff) == 0 ? kNaN : (((dice >> 32) & 0x3ff) == 1 ? t - 1.0 : t);
      const LadderState next = step(config, s, now, present, ((dice >> 42) & 3) == 0);
      ASSERT_TRUE(allowed(s.action, next.action)) << to_string(s.action) << " -> " << to_string(next.action);
      ASSERT_EQ(next.action == Action::fly, !next.cause.has_value());
      for (std::size_t f = 0; f < kFaults; ++f) {
        ASSERT_TRUE(!next.fired[f] || next.action >= config.rungs[f].action) << "the worst does not win";
      }
      ++seen[static_cast<std::size_t>(s.action)][static_cast<std::size_t>(next.action)];
      s = next;
    }
  }
  for (std::size_t from = 0; from < kActions; ++from) {
    for (std::size_t to = 0; to < kActions; ++to) {
      EXPECT_EQ(seen[from][to] > 0, allowed(static_cast<Action>(from), static_cast<Action>(to)))
          << from << to;
    }
  }
}

TEST(Ladder, IsAFunctionOfItsArguments) {
  const LadderConfig config = LadderConfig::standard();
  LadderState s = armed(config);
  for (int k = 1; k < 400; ++k) {
    const FaultSet present = k % 3 ? only(Fault::pose_lost) : FaultSet{};
    const LadderState a = step(config, s, 0.01 * k, present), b = step(config, s, 0.01 * k, present);
    ASSERT_TRUE(a == b);
    s = a;
  }
}

TEST(Ladder, AFaultWithHalfDutyFiresWithinTwiceItsDelayWhateverItsPeriod) {
  const LadderConfig config = LadderConfig::standard();
  for (std::size_t f = 0; f < kFaults; ++f) {
    const auto [action, delay_s] = config.rungs[f];
    if (action == Action::fly || delay_s == 0) continue;
    for (const double half_s : {0.1 * delay_s, 0.3 * delay_s, 0.7 * delay_s, 1.0 * delay_s, 3.0 * delay_s}) {
      LadderState s = armed(config);
      const double dt = 0.01 * half_s;
      double fired_at = -1;
      for (int k = 1; fired_at < 0 && k * dt < 10 * delay_s; ++k) {
        const bool on = ((k - 1) / 100) % 2 == 0;
        s = step(config, s, k * dt, on ? only(static_cast<Fault>(f)) : FaultSet{});
        if (s.fired[f]) fired_at = k * dt;
      }
      EXPECT_GT(fired_at, 0) << to_string(static_cast<Fault>(f)) << " half period " << half_s;
      EXPECT_LE(fired_at, 2 * delay_s + 2 * dt)
          << to_string(static_cast<Fault>(f)) << " half period " << half_s;
    }
  }
}

TEST(Ladder, MomentaryFaultsNeverAddUp) {
  const LadderConfig config = LadderConfig::standard();
  LadderState s = armed(config);
  for (int k = 1; k < 100000; ++k) {  // 0.1 s of every 2 s, for 1000 s
    s = step(config, s, 0.01 * k, k % 200 < 10 ? only(Fault::pose_lost) : FaultSet{});
    ASSERT_EQ(s.action, Action::fly) << 0.01 * k;
  }
}

TEST(Ladder, ArmingIsRefusedWithTheNamesOfWhatIsWrong) {
  const LadderConfig config = LadderConfig::standard();
  FaultSet present = only(Fault::pose_lost) | only(Fault::recorder_lost);
  const auto refused = arm(config, {}, 0.0, present);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("recorder_lost, pose_lost"), std::string::npos)
      << refused.error().text();
  EXPECT_FALSE(arm(config, {}, 0.0, only(Fault::planner_lost)));
  EXPECT_FALSE(arm(config, {}, kNaN, {}));
  EXPECT_FALSE(arm(config, armed(config), 1.0, {}));
  const LadderState off = step(config, armed(config), 1.0, only(Fault::emergency_stop));
  ASSERT_EQ(off.action, Action::off);
  const auto again = arm(config, off, 2.0, {});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->action, Action::fly);
}

TEST(Ladder, WhatIsToBeFlownThroughForbidsNoArming) {
  LadderConfig config = LadderConfig::standard();
  config.rungs[index(Fault::battery_low)].action = Action::fly;
  EXPECT_TRUE(arm(config, {}, 0.0, only(Fault::battery_low)));
}

TEST(Ladder, BeforeArmingNothingHappens) {
  const LadderState s = step(LadderConfig::standard(), {}, 5.0, only(Fault::pose_lost));
  EXPECT_TRUE(s == LadderState{});
}

TEST(Ladder, AHoldTakesTheCauseThatIsLeft) {
  const LadderConfig config = LadderConfig::standard();
  LadderState s = step(config, armed(config), 0.1, only(Fault::operator_hold));
  for (int k = 2; k < 40; ++k)
    s = step(config, s, 0.1 * k,
             only(Fault::battery_low) | (k < 30 ? only(Fault::operator_hold) : FaultSet{}));
  EXPECT_EQ(s.action, Action::hold);
  EXPECT_EQ(s.cause, Fault::battery_low);
}

TEST(Ladder, RefusesDelaysThatAreNone) {
  const auto error = [](auto change) {
    LadderConfig c = LadderConfig::standard();
    change(c);
    const auto ok = check(c);
    return ok ? std::string() : ok.error().text();
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_NE(error([](auto& c) { c.rungs[index(Fault::pose_lost)].delay_s = -1; }).find("pose_lost.delay_s"),
            std::string::npos);
  EXPECT_NE(error([](auto& c) { c.rungs[0].delay_s = kNaN; }).find("recorder_lost"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.hold_limit_s = kNaN; }).find("hold_limit_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.descend_limit_s = -1; }).find("descend_limit_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.ramp_s = 0; }).find("ramp_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.hold_limit_s = -1; }).find("hold_limit_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.descend_limit_s = kNaN; }).find("descend_limit_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.ramp_s = kNaN; }).find("ramp_s"), std::string::npos);
}

TEST(Ladder, NamesDiffer) {
  std::set<std::string_view> names;
  for (std::size_t k = 0; k < kFaults; ++k) names.insert(to_string(static_cast<Fault>(k)));
  for (std::size_t k = 0; k < kActions; ++k) names.insert(to_string(static_cast<Action>(k)));
  EXPECT_EQ(names.size(), kFaults + kActions);
}

}  // namespace
}  // namespace omniflight::safety
