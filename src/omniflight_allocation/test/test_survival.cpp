// The map of survival: what it says of each method, and that a cell is the flight it stands for.
#include <gtest/gtest.h>

#include "omniflight_allocation/allocator.hpp"
#include "omniflight_allocation/survival.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

SurvivalConfig coarse() {
  SurvivalConfig c;
  c.roll_times = {3, 6};
  c.tilt_steps = {to_radians(0.1), to_radians(0.3), to_radians(1.0)};
  return c;
}

const SurvivalMap& map() {
  static const SurvivalMap all = survival_map(omnimorph(), coarse()).value();
  return all;
}

TEST(Survival, LookAheadSurvivesWhereverTheOthersDoAndWhereTheyDoNot) {
  EXPECT_EQ(map().cells.size(), 24u);
  for (const TiltMethod greedy : {TiltMethod::case_a, TiltMethod::case_b, TiltMethod::dynamic})
    for (const TiltMethod planned : {TiltMethod::look_ahead, TiltMethod::look_ahead_told}) {
      const SurvivalComparison c = compare(map(), greedy, planned);
      EXPECT_EQ(c.only_first, 0) << words(greedy);
      EXPECT_LT(c.first, 20) << words(greedy);
      EXPECT_EQ(c.second, 24) << words(planned);
    }
}

/// A plan that does not know of a loss at small tilts goes there to save power, and needs more.
TEST(Survival, LookAheadNeedsLessPowerThanCaseAWhereItKnowsTheLoss) {
  const SurvivalComparison told = compare(map(), TiltMethod::case_a, TiltMethod::look_ahead_told);
  EXPECT_GE(told.both, 12);
  EXPECT_EQ(told.second_needs_less, told.both);
  EXPECT_LT(told.highest, 1.0);
  int dearer_under_the_rising_share = 0;
  for (const SurvivalCell& cell : map().cells) {
    const Survival &a = cell.of(TiltMethod::case_a), &ahead = cell.of(TiltMethod::look_ahead);
    if (!a.survived) continue;
    const ThrustShare& share = map().config.shares[cell.share];
    if (share.at_low == share.at_high)
      EXPECT_LT(ahead.mean_power, a.mean_power) << share.words();
    else
      dearer_under_the_rising_share += ahead.mean_power > a.mean_power;
  }
  EXPECT_GE(dearer_under_the_rising_share, 1);
}

TEST(Survival, ACellIsTheFlightOfItsRollTimeAndStep) {
  for (const SurvivalCell& cell : map().cells) {
    const SurvivalConfig& c = map().config;
    if (c.shares[cell.share].at_low != 1) continue;
    AllocatorConfig a = AllocatorConfig::case_a();
    a.tilt_step = c.tilt_steps[cell.tilt_step];
    const double seconds = c.roll_times[cell.roll_time];
    const LoopResult r = fly(
        omnimorph(), a, [=](double t) { return roll_reference(t, seconds); }, seconds + 3,
        [](double) { return 1.0; });
    EXPECT_EQ(cell.of(TiltMethod::case_a).worst_error, r.worst_error);
    EXPECT_EQ(cell.of(TiltMethod::case_a).survived,
              !r.failed && r.worst_error < 0.5 && to_degrees(r.worst_angle) < 45);
  }
}

TEST(Survival, RefusesWhatItCannotMapAndStopsWhenItIsTold) {
  const auto refusal = [](const vehicle::Vehicle& v, const SurvivalConfig& c) {
    const auto m = survival_map(v, c, [](double) { return false; });
    return m ? std::string("accepted") : m.error().text();
  };
  EXPECT_NE(refusal(omnimorph(), coarse()).find("stopped"), std::string::npos);
  vehicle::Vehicle fixed = omnimorph();
  fixed.tilt = {};
  EXPECT_NE(refusal(fixed, coarse()).find("does not tilt"), std::string::npos);
  SurvivalConfig c = coarse();
  c.shares = {{0, 1}};
  EXPECT_NE(refusal(omnimorph(), c).find("shares"), std::string::npos);
  c = coarse();
  c.roll_times.clear();
  EXPECT_NE(refusal(omnimorph(), c).find("roll_times"), std::string::npos);
  c = coarse();
  c.tilt_steps = {std::nan("")};
  EXPECT_NE(refusal(omnimorph(), c).find("tilt_steps"), std::string::npos);
  c = coarse();
  c.reserve = 1;
  EXPECT_NE(refusal(omnimorph(), c).find("reserve"), std::string::npos);
}

}  // namespace
}  // namespace omniflight::allocation
