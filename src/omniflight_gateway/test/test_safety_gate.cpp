// Every way out of every state of the safety gate, and that nothing else exists.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <omniflight_core/random.hpp>

#include "omniflight_gateway/safety_gate.hpp"

namespace omniflight::gateway {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

GateConfig two_rotors() {
  GateConfig c;
  c.rotors = 2;
  c.max_speed_radps = 1000;
  c.max_acceleration_radps2 = 1e5;
  return c;
}
SafetyGate make(const GateConfig& config = two_rotors()) { return *SafetyGate::create(config); }
SafetyGate armed(double now_s = 10.0) {
  SafetyGate gate = make();
  EXPECT_TRUE(gate.arm(now_s));
  return gate;
}
using Speeds = std::vector<double>;

TEST(SafetyGate, RefusesConfigurationsThatWouldNotProtect) {
  const auto error = [](auto change) {
    GateConfig c = two_rotors();
    change(c);
    const auto gate = SafetyGate::create(c);
    return gate ? std::string() : gate.error().text();
  };
  EXPECT_NE(error([](auto& c) { c.max_speed_radps = 0; }).find("max_speed_radps"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.max_speed_radps = kNaN; }).find("max_speed_radps"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.max_acceleration_radps2 = kInf; }).find("rad/s^2"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.stale_after_s = -1; }).find("stale_after_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.ramp_s = 0; }).find("ramp_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.fresh_for_s = 0; }).find("fresh_for_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.fresh_for_s = 0.2; }).find("stale_after_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.own_sleep_s = kNaN; }).find("own_sleep_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.future_tolerance_s = 0; }).find("future_tolerance_s"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.rotors = 0; }).find("rotors"), std::string::npos);
  EXPECT_EQ(error([](auto&) {}), "");
}

TEST(SafetyGate, RefusesEachBadCommandForItsReasonAndCountsIt) {
  const struct {
    Speeds speeds;
    double stamp_s;
    Refusal why;
  } cases[] = {{{1, 2, 3}, 10.05, Refusal::wrong_count},
               {{}, 10.05, Refusal::wrong_count},
               {{kNaN, 0}, 10.05, Refusal::not_finite},
               {{0, -kInf}, 10.05, Refusal::not_finite},
               {{0, 0}, kNaN, Refusal::not_finite},
               {{0, 1000.001}, 10.05, Refusal::too_fast},
               {{-1000.001, 0}, 10.05, Refusal::too_fast},
               {{1e308, 0}, 10.05, Refusal::too_fast},
               {{0, 0}, 9.94, Refusal::stale},
               {{0, 0}, 10.07, Refusal::from_future},
               {{0, 0}, 10.0, Refusal::out_of_order},
               {{0, 0}, 9.99, Refusal::out_of_order},
               {{0, 501}, 10.005, Refusal::too_sudden},
               {{-501, 0}, 10.005, Refusal::too_sudden}};
  for (const auto& c : cases) {
    SafetyGate gate = armed();
    const auto refusal = gate.offer(c.speeds, c.stamp_s, 10.05);
    ASSERT_TRUE(refusal) << to_string(c.why);
    EXPECT_EQ(to_string(*refusal), to_string(c.why));
    EXPECT_EQ(gate.refused(c.why), 1u);
    EXPECT_EQ(gate.refused(), 1u);
    EXPECT_EQ(gate.accepted(), 0u);
    EXPECT_EQ(gate.update(10.05).speeds_radps[0], 0.0);
  }
}

TEST(SafetyGate, PassesGoodCommandsUpToTheLimits) {
  SafetyGate gate = armed();
  EXPECT_FALSE(gate.offer(Speeds{1000, -1000}, 10.01, 10.01));
  const auto out = gate.update(10.01);
  EXPECT_EQ(out.state, GateState::armed);
  EXPECT_FALSE(out.stop_motors);
  EXPECT_EQ(Speeds(out.speeds_radps.begin(), out.speeds_radps.end()), (Speeds{1000, -1000}));
  EXPECT_TRUE(gate.offer(Speeds{1000, -1000}, 10.01, 10.01));  // the same stamp again
  EXPECT_EQ(gate.accepted(), 1u);
}

TEST(SafetyGate, NothingPassesBeforeArming) {
  SafetyGate gate = make();
  EXPECT_EQ(gate.offer(Speeds{1, 1}, 1.0, 1.0), Refusal::not_armed);
  const auto out = gate.update(1.0);
  EXPECT_TRUE(out.stop_motors);
  EXPECT_EQ(out.state, GateState::disarmed);
  EXPECT_FALSE(gate.arm(kNaN));
  EXPECT_TRUE(gate.arm(1.0));
  EXPECT_FALSE(gate.arm(1.0));
}

/// Updates every millisecond up to and including `until_s`; the output of the last.
GateOutput run(SafetyGate& gate, double from_s, double until_s) {
  GateOutput out;
  const auto steps = static_cast<int>(std::lround((until_s - from_s) * 1e3));
  for (int k = 1; k <= steps; ++k) out = gate.update(from_s + 1e-3 * k);
  return out;
}

TEST(SafetyGate, NoCommandIsRepeatedBeyondOnePeriodAndFiveMilliseconds) {
  SafetyGate gate = armed();
  ASSERT_FALSE(gate.offer(Speeds{800, -400}, 10.02, 10.02));
  double last = 800;
  for (int ms = 1; ms <= 600; ++ms) {
    const auto out = gate.update(10.02 + 1e-3 * ms);
    if (ms <= 15) {
      EXPECT_NEAR(out.speeds_radps[0], 800, 1e-9) << ms;
      continue;
    }
    ASSERT_LE(out.speeds_radps[0], std::max(0.0, last - 1.6 + 1e-9)) << ms << " ms: 800 rad/s in 0.5 s";
    ASSERT_NEAR(out.speeds_radps[1], -0.5 * out.speeds_radps[0], 1e-9);
    last = out.speeds_radps[0];
  }
  EXPECT_EQ(gate.state(), GateState::stopped);
}

TEST(SafetyGate, ANewCommandEndsFadingUntilItIsStale) {
  SafetyGate gate = armed();
  ASSERT_FALSE(gate.offer(Speeds{800, -400}, 10.02, 10.02));
  const auto faded = run(gate, 10.02, 10.085);
  EXPECT_EQ(faded.state, GateState::fading);
  EXPECT_NEAR(faded.speeds_radps[0], 720, 1e-6);  // 0.05 s of 0.5 s
  ASSERT_FALSE(gate.offer(Speeds{810, -410}, 10.085, 10.085));
  EXPECT_EQ(gate.update(10.086).state, GateState::armed);
  EXPECT_EQ(gate.update(10.087).speeds_radps[0], 810);
  run(gate, 10.087, 10.187);
  EXPECT_EQ(gate.state(), GateState::ramping);
  EXPECT_EQ(gate.offer(Speeds{810, -410}, 10.187, 10.187), Refusal::not_armed);
}

TEST(SafetyGate, ItsOwnSleepIsNoSilenceOfTheCommander) {
  GateConfig config = two_rotors();
  config.stale_after_s = 1.0;
  SafetyGate gate = make(config);
  ASSERT_TRUE(gate.arm(10.0));
  ASSERT_FALSE(gate.offer(Speeds{800, -400}, 10.01, 10.01));
  const auto out = gate.update(10.51);  // the whole machine stood still
  EXPECT_EQ(out.state, GateState::fading);
  EXPECT_NEAR(out.speeds_radps[0], 800 * (1 - 0.005 / 0.5), 1e-9);
  EXPECT_FALSE(gate.offer(Speeds{800, -400}, 10.511, 10.511));
  EXPECT_EQ(gate.update(10.512).speeds_radps[0], 800);
}

TEST(SafetyGate, ATripContinuesWhereFadingHasArrived) {
  SafetyGate gate = armed();
  ASSERT_FALSE(gate.offer(Speeds{800, -400}, 10.02, 10.02));
  run(gate, 10.02, 10.085);
  gate.trip(Trip::requested, 10.085);
  EXPECT_NEAR(gate.update(10.086).speeds_radps[0], 720 - 1.6, 1e-6);
  EXPECT_EQ(gate.state(), GateState::ramping);
}

TEST(SafetyGate, SilenceWindsDownWithinTheRampAndStaysStopped) {
  SafetyGate gate = armed();
  ASSERT_FALSE(gate.offer(Speeds{800, -400}, 10.02, 10.02));
  EXPECT_EQ(run(gate, 10.02, 10.12).state, GateState::fading);
  EXPECT_EQ(gate.update(10.121).state, GateState::ramping);
  EXPECT_EQ(gate.trip_reason(), Trip::stale_command);
  // The ramp counts from when the command stopped being fresh.
  const auto half = gate.update(10.035 + 0.25);
  EXPECT_NEAR(half.speeds_radps[0], 400, 1e-6);
  EXPECT_NEAR(half.speeds_radps[1], -200, 1e-6);
  EXPECT_EQ(gate.offer(Speeds{400, -200}, 10.3, 10.3), Refusal::not_armed);
  EXPECT_FALSE(gate.arm(10.4));  // still turning
  const auto end = gate.update(10.035 + 0.5 + 1e-9);
  EXPECT_EQ(end.state, GateState::stopped);
  EXPECT_TRUE(end.stop_motors);
  EXPECT_EQ(end.speeds_radps[0], 0.0);
  EXPECT_EQ(gate.offer(Speeds{0, 0}, 11.0, 11.0), Refusal::not_armed);
  EXPECT_TRUE(gate.arm(11.0));
  EXPECT_EQ(gate.trip_reason(), Trip::none);
  EXPECT_EQ(gate.update(11.0).speeds_radps[0], 0.0);  // not the old command
}

TEST(SafetyGate, ALateCommandCannotOvertakeTheWatchdog) {
  SafetyGate gate = armed();
  ASSERT_FALSE(gate.offer(Speeds{100, 100}, 10.05, 10.05));
  EXPECT_EQ(gate.offer(Speeds{100, 100}, 10.2, 10.2), Refusal::not_armed);
  EXPECT_EQ(gate.state(), GateState::ramping);
}

TEST(SafetyGate, TripAndCut) {
  SafetyGate gate = armed();
  ASSERT_FALSE(gate.offer(Speeds{100, 100}, 10.05, 10.05));
  gate.trip(Trip::link_lost, 10.06);
  gate.trip(Trip::requested, 10.07);  // the first reason stays
  EXPECT_EQ(gate.trip_reason(), Trip::link_lost);
  EXPECT_NEAR(gate.update(10.16).speeds_radps[0], 80, 1e-9);
  gate.cut(Trip::board_emergency);
  EXPECT_EQ(gate.trip_reason(), Trip::link_lost);
  EXPECT_TRUE(gate.update(10.17).stop_motors);
  gate.trip(Trip::requested, 10.18);
  EXPECT_EQ(gate.state(), GateState::stopped);
}

TEST(SafetyGate, ABrokenClockCutsAtOnce) {
  for (const double bad_now : {kNaN, kInf, 5.0}) {
    SafetyGate gate = armed();
    ASSERT_FALSE(gate.offer(Speeds{100, 100}, 10.05, 10.05));
    EXPECT_TRUE(gate.update(bad_now).stop_motors);
    EXPECT_EQ(gate.trip_reason(), Trip::clock);
  }
  SafetyGate gate = armed();  // a step back within the tolerance is jitter
  EXPECT_EQ(gate.update(9.95).state, GateState::armed);
}

TEST(SafetyGate, NamesOfAllReasonsDiffer) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kRefusalCount; ++i) names.push_back(to_string(static_cast<Refusal>(i)));
  for (std::size_t i = 0; i < kTripCount; ++i) names.push_back(to_string(static_cast<Trip>(i)));
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
}

/// Random drives over a long time: whatever comes in, the output stays finite, in range, free of jumps, and
/// the only edges are the documented ones.
TEST(SafetyGate, AnyInputKeepsTheOutputSafe) {
  Random random(5, "gate");
  SafetyGate gate = make();
  double now_s = 0.0;
  GateState before = gate.state();
  double last_output = 0.0;
  std::size_t armed_steps = 0, ramps = 0;
  for (int i = 0; i < 400000; ++i) {
    now_s += random.uniform() < 0.002 ? 0.3 * random.uniform() : 2e-3 * random.uniform();
    bool armed_now = false, cut_now = false;
    const double dice = random.uniform();
    if (dice < 0.003) {
      armed_now = gate.arm(now_s).has_value();
    } else if (dice < 0.0032) {
      gate.trip(Trip::requested, now_s);
    } else if (dice < 0.0033) {
      gate.cut(Trip::requested);
      cut_now = true;
    } else {
      Speeds s = {random.uniform(-200, 200), random.uniform(-200, 200)};
      if (dice < 0.1)
        s[random.next() % 2] = std::vector<double>{kNaN, kInf, -kInf, 1e308, 5000}[random.next() % 5];
      const double stamp_s = dice < 0.2 ? now_s + random.uniform(-1, 1) : now_s;
      gate.offer(s, dice < 0.21 && dice > 0.2 ? kNaN : stamp_s, now_s);
    }
    const auto out = gate.update(now_s);
    for (const double s : out.speeds_radps) {
      ASSERT_TRUE(std::isfinite(s));
      ASSERT_LE(std::abs(s), 1000.0);
    }
    if (out.state != before) {
      const bool to_armed = out.state == GateState::armed;
      ASSERT_TRUE(!to_armed || before == GateState::fading || (armed_now && before != GateState::ramping))
          << i;
      ASSERT_TRUE(out.state != GateState::fading || before == GateState::armed || armed_now) << i;
      ASSERT_NE(out.state, GateState::disarmed);
      if (out.state == GateState::ramping) ++ramps;
    }
    if (out.state == GateState::ramping && before == GateState::ramping) {
      ASSERT_LE(std::abs(out.speeds_radps[0]), std::abs(last_output) + 1e-12);
    }
    if (cut_now) {
      ASSERT_EQ(out.state, GateState::stopped);
    }
    armed_steps += out.state == GateState::armed ? 1 : 0;
    last_output = out.speeds_radps[0];
    before = out.state;
  }
  EXPECT_GT(armed_steps, 10000u);
  EXPECT_GT(ramps, 100u);
  EXPECT_GT(gate.accepted(), 10000u);
}

}  // namespace
}  // namespace omniflight::gateway
