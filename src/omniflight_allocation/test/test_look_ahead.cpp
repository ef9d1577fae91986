// The tilt of a whole motion at once: within its limits, optimal on a small grid, and where a search from
// period to period loses the vehicle.
#include <gtest/gtest.h>

#include "omniflight_allocation/allocator.hpp"
#include "omniflight_allocation/closed_loop.hpp"
#include "omniflight_allocation/look_ahead.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

/// A full roll on the spot after two seconds of hover.
Motion six_second_roll() {
  return [](double t) { return roll_reference(t, 6.0); };
}
constexpr double kRollEnds = 9.0;  // s

double nominal(double) { return 1.0; }

TEST(LookAhead, KeepsLimitsAndRateAndRestsWhereNothingIsGained) {
  const vehicle::Vehicle v = omnimorph();
  LookAheadConfig config;
  config.rate = to_radians(10);
  const auto s = look_ahead(v, six_second_roll(), kRollEnds, config);
  ASSERT_TRUE(s) << s.error().text();
  ASSERT_GT(s->alpha.size(), 100u);
  for (std::size_t k = 0; k < s->alpha.size(); ++k) {
    EXPECT_GE(s->alpha[k], v.tilt.min);
    EXPECT_LE(s->alpha[k], v.tilt.max);
    if (k > 0) {
      EXPECT_LE(std::abs(s->alpha[k] - s->alpha[k - 1]), config.rate * s->period * (1 + 1e-9));
    }
  }
  EXPECT_GE((static_cast<double>(s->alpha.size()) - 1) * s->period, kRollEnds);
  EXPECT_LT(s->missing, 0.05) << "the whole roll is achieved";
  const auto still = look_ahead(
      v, [](double) { return Reference{}; }, 3.0, config);
  ASSERT_TRUE(still);
  for (const double alpha : still->alpha) EXPECT_EQ(alpha, still->alpha[0]);
}

/// One share at every tilt is a vehicle with weaker rotors: the same plan.
TEST(LookAhead, AConstantShareOfThrustIsAWeakerVehicle) {
  LookAheadConfig told;
  told.rate = to_radians(10);
  told.thrust_share = [](double) { return 0.65; };
  LookAheadConfig weaker = told;
  weaker.thrust_share = {};
  weaker.weights.w_input /= 0.65 * 0.65;
  vehicle::Vehicle weak = omnimorph();
  for (vehicle::Rotor& r : weak.rotors) r.max_thrust *= 0.65, r.min_thrust *= 0.65;
  const auto of_share = look_ahead(omnimorph(), six_second_roll(), kRollEnds, told);
  const auto of_weak = look_ahead(weak, six_second_roll(), kRollEnds, weaker);
  ASSERT_TRUE(of_share && of_weak);
  EXPECT_EQ(of_share->alpha, of_weak->alpha);
  EXPECT_NEAR(of_share->missing, of_weak->missing, 1e-9);
}

/// All sequences of a short motion on a coarse grid, one by one.
TEST(LookAhead, IsTheBestOfAllSequences) {
  const vehicle::Vehicle v = omnimorph();
  LookAheadConfig config;
  config.grid = to_radians(15);  // 0, 15, 30, 45, 60 deg
  config.period = 0.5;
  config.rate = to_radians(30);  // one tilt a decision
  config.reserve = 0;
  const auto motion = [](double t) { return roll_reference(t + 2.0, 5.0); };
  const auto s = look_ahead(v, motion, 2.5, config);
  ASSERT_TRUE(s) << s.error().text();
  ASSERT_EQ(s->alpha.size(), 6u);
  AllocatorConfig fixed = config.weights;
  fixed.tilt_mode = TiltMode::fixed;
  fixed.w_rate = 0;
  auto allocator = Allocator::create(v, fixed).value();
  double cost[6][5];
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 5; ++j) {
      const Reference r = motion(0.5 * k);
      AllocationInput in;
      in.qdd_ref << r.a_WB_W, r.dw_WB_B;
      in.q_WB = r.q_WB;
      in.w_WB_B = r.w_WB_B;
      in.alpha = to_radians(15 * j);
      cost[k][j] = allocator.allocate(in)->cost;
    }
  double best = HUGE_VAL, found = 0;
  for (int code = 0; code < 5 * 5 * 5 * 5 * 5 * 5; ++code) {
    double sum = 0;
    int rest = code, before = -1;
    for (int k = 0; k < 6; ++k, rest /= 5) {
      const int j = rest % 5;
      if (k > 0 && std::abs(j - before) > 1) sum = HUGE_VAL;
      sum += cost[k][before = j];
    }
    best = std::min(best, sum);
  }
  for (int k = 0; k < 6; ++k)
    found += cost[k][std::lround(to_degrees(s->alpha[static_cast<std::size_t>(k)]) / 15)];
  EXPECT_NEAR(found, best, 1e-7 * best);
}

/// 0.1 deg a period of 10 ms, from 30 deg: what a search from period to period cannot see coming.
TEST(LookAhead, FliesTheRollThatTheGreedySearchLoses) {
  const vehicle::Vehicle v = omnimorph();
  LookAheadConfig config;
  config.rate = to_radians(10);
  config.initial = to_radians(30);
  for (const AllocatorConfig& weights : {AllocatorConfig::case_a(), AllocatorConfig::case_b()}) {
    AllocatorConfig greedy = weights;
    greedy.tilt_step = to_radians(0.1);
    const LoopResult thrown = fly(v, greedy, six_second_roll(), kRollEnds, nominal);
    config.weights = weights;
    const auto s = look_ahead(v, six_second_roll(), kRollEnds, config);
    ASSERT_TRUE(s) << s.error().text();
    const LoopResult flown =
        fly(v, weights, six_second_roll(), kRollEnds, nominal, {}, [&](double t) { return s->at(t); });
    EXPECT_GT(thrown.worst_error, 0.2);  // m, and 25 deg or more
    EXPECT_GT(to_degrees(thrown.worst_angle), 20);
    EXPECT_FALSE(flown.failed);
    EXPECT_LT(flown.worst_error, 1e-3);
    EXPECT_LT(flown.mean_power, 0.85 * thrown.mean_power);
  }
}

/// Beyond the thesis: with a reserve of 0.4 and dynamic weights it survives wherever case A does, and where A
/// does not.
TEST(LookAhead, SurvivesWhereverCaseADoes) {
  const vehicle::Vehicle v = omnimorph();
  const auto constant = [](double) { return 0.65; };
  const auto lossy = [](double alpha) { return 0.35 + 0.35 * alpha / to_radians(60.0); };
  AllocatorConfig a = AllocatorConfig::case_a(), dynamic = AllocatorConfig::case_b();
  dynamic.dynamic_weights.enabled = true;
  int survived = 0, a_survived = 0;
  double power = 0, a_power = 0;  // W, of nominal flights that both survive
  for (const double seconds : {1.2, 1.6, 2.0, 3.0})
    for (const double rate_deg : {10.0, 30.0})
      for (const std::function<double(double)>& plant :
           {std::function<double(double)>(nominal), {constant}, {lossy}}) {
        const auto motion = [&](double t) { return thesis_reference(t, seconds); };
        const double duration = 10 + 2 * seconds;
        LookAheadConfig config;
        config.rate = to_radians(rate_deg);
        config.reserve = 0.4;
        const auto s = look_ahead(v, motion, duration, config);
        ASSERT_TRUE(s) << s.error().text();
        a.tilt_step = to_radians(0.01 * rate_deg);
        const LoopResult of_a = fly(v, a, motion, duration, plant);
        const LoopResult ahead =
            fly(v, dynamic, motion, duration, plant, {}, [&](double t) { return s->at(t); });
        EXPECT_FALSE(ahead.failed) << seconds << " s, " << rate_deg << " deg/s";
        EXPECT_LT(ahead.worst_error, 0.08) << seconds << " s, " << rate_deg << " deg/s";
        survived += !ahead.failed;
        a_survived += !of_a.failed;
        if (plant(0.0) == 1.0 && !of_a.failed) power += ahead.mean_power, a_power += of_a.mean_power;
      }
  EXPECT_EQ(survived, 24);
  EXPECT_LT(a_survived, 16);
  EXPECT_LT(power, a_power);
}

TEST(LookAhead, RefusesWhatItCannotDo) {
  const vehicle::Vehicle v = omnimorph();
  const auto refusal = [&](const vehicle::Vehicle& of, double duration, LookAheadConfig config) {
    const auto s = look_ahead(of, six_second_roll(), duration, config);
    return s ? std::string("accepted") : s.error().text();
  };
  EXPECT_EQ(refusal(v, 1, {}), "accepted");
  vehicle::Vehicle fixed = v;
  fixed.tilt = {};
  EXPECT_NE(refusal(fixed, 1, {}).find("does not tilt"), std::string::npos);
  vehicle::Vehicle unknown = v;
  unknown.tilt.rate = 0;
  EXPECT_NE(refusal(unknown, 1, {}).find("rate"), std::string::npos);
  EXPECT_NE(refusal(v, 1, {.reserve = 1.0}).find("reserve"), std::string::npos);
  EXPECT_NE(refusal(v, 1, {.thrust_share = [](double) { return 0.0; }}).find("thrust_share"),
            std::string::npos);
  EXPECT_NE(refusal(v, 1, {.grid = 0}).find("grid"), std::string::npos);
  EXPECT_NE(refusal(v, std::nan(""), {}).find("duration"), std::string::npos);
  EXPECT_NE(refusal(v, 1, {.initial = to_radians(80)}).find("initial"), std::string::npos);
  EXPECT_NE(refusal(v, 3600, {.grid = to_radians(0.05), .period = 0.001}).find("cells"), std::string::npos);
  const auto s = look_ahead(
      v,
      [](double) {
        Reference r;
        r.a_WB_W.x() = NAN;
        return r;
      },
      1);
  EXPECT_FALSE(s);
}

}  // namespace
}  // namespace omniflight::allocation
