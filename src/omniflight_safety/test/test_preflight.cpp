// Rotors are not started when something is missing, and all of it is named at once.
#include <gtest/gtest.h>

#include "omniflight_safety/preflight.hpp"

namespace omniflight::safety {
namespace {

Readiness ready() { return {1, 1, true, 1'000'000'000, 0.01, 15.0, {}}; }

std::string error(const Readiness& found, PreflightLimits limits = {}) {
  limits.battery_V = 14.0;
  const auto ok = preflight(limits, found);
  return ok ? std::string() : ok.error().text();
}

TEST(Preflight, PassesWhatIsReady) { EXPECT_EQ(error(ready()), ""); }

TEST(Preflight, NamesEverythingThatIsMissing) {
  const std::string text = error({});
  for (const char* what : {"nobody publishes rotor commands", "nobody publishes poses", "no recorder",
                           "no pose has come", "battery voltage unknown"})
    EXPECT_NE(text.find(what), std::string::npos) << what << " is missing in: " << text;
}

TEST(Preflight, NamesEachByItsSize) {
  const auto with = [](auto change) {
    Readiness r = ready();
    change(r);
    return error(r);
  };
  EXPECT_NE(with([](auto& r) { r.commanders = 2; }).find("2 publishers of rotor commands"),
            std::string::npos);
  EXPECT_NE(with([](auto& r) { r.pose_sources = 3; }).find("3 publishers of poses"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.free_bytes = 5'000'000; }).find("5 MB left"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.pose_age_s = 0.7; }).find("0.7"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.battery_V = 13.0; }).find("13.0"), std::string::npos);
  EXPECT_EQ(with([](auto& r) { r.free_bytes.reset(); }), "");
  const auto clock = [](std::optional<double> share) {
    Readiness r = ready();
    r.missed_share = share;
    PreflightLimits limits;
    limits.missed_share = 0.05;
    return error(r, limits);
  };
  EXPECT_EQ(clock(0.01), "");
  EXPECT_NE(clock(0.2).find("20.000000 % of the periods missed"), std::string::npos) << clock(0.2);
  EXPECT_NE(clock({}).find("the clock has not been observed"), std::string::npos);
}

TEST(Preflight, ABatteryThatIsNotJudgedMayBeUnknown) {
  Readiness r = ready();
  r.battery_V.reset();
  EXPECT_TRUE(preflight({}, r));
}

TEST(Preflight, ARecorderMayBeWaived) {
  Readiness r = ready();
  r.recorder = false;
  r.free_bytes = 0;
  EXPECT_NE(error(r), "");
  PreflightLimits limits;
  limits.recorder = false;
  EXPECT_EQ(error(r, limits), "");
}

}  // namespace
}  // namespace omniflight::safety
