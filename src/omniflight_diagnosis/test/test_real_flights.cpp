// Real flights, where they are at hand: OMNIFLIGHT_REAL_DATA or ../shared/data beside the checkout.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_recording/formats.hpp"

namespace omniflight::diagnosis {
namespace {

std::filesystem::path flights() {
  const char* given = std::getenv("OMNIFLIGHT_REAL_DATA");
  return (given ? std::filesystem::path(given)
                : std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT "/../shared/data")) /
         "flights";
}

std::vector<recording::Recording> load_all(const std::vector<std::string>& names) {
  std::vector<recording::Recording> out;
  for (const std::string& name : names) {
    auto r = recording::load(flights() / name);
    EXPECT_TRUE(r) << r.error().text();
    if (r) out.push_back(std::move(*r));
  }
  return out;
}

bool named(const Diagnosis& d, const std::string& effect) {
  return std::any_of(d.findings.begin(), d.findings.end(),
                     [&](const Finding& f) { return f.effect == effect; });
}

TEST(RealFlights, RotorDragIsNamedAndNoLoad) {
  if (!std::filesystem::exists(flights() / "crazyflie_brushless/eckart00"))
    GTEST_SKIP() << "no recordings at " << flights() << "; set OMNIFLIGHT_REAL_DATA";
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto v = vehicle::load_vehicle("crazyflie_brushless");
  ASSERT_TRUE(v) << v.error().text();
  const std::string f = "crazyflie_brushless/eckart";
  const auto fit = load_all({f + "00", f + "06", f + "12", f + "17", f + "22"});
  const auto held_out = load_all({f + "01", f + "07", f + "13", f + "18"});
  const auto d = diagnose(fit, held_out, *v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_GE(d->candidates.size(), 8u);
  EXPECT_TRUE(named(*d, "rotor_drag")) << d->summary;
  for (const char* absent :
       {"payload_mass", "hung_cable", "constant_pull", "wind", "lateral_stiffness", "thrust_scale"})
    EXPECT_FALSE(named(*d, absent)) << d->summary;
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  for (const ChannelFit& c : d->fit.held_out) {
    if (c.channel == "ax") x0 += c.rms_before / 4, x1 += c.rms_after / 4;
    if (c.channel == "ay") y0 += c.rms_before / 4, y1 += c.rms_after / 4;
  }
  RecordProperty("held_out_ax", std::to_string(x1));
  EXPECT_GT(x0, 0.15);
  EXPECT_GT(y0, 0.15);
  EXPECT_LE(x1, 0.09);
  EXPECT_LE(y1, 0.10);
  const auto inertia = std::find_if(d->findings.begin(), d->findings.end(),
                                    [](const Finding& x) { return x.effect == "rotor_inertia"; });
  ASSERT_NE(inertia, d->findings.end()) << d->summary;
  // the propeller alone has 3.9e-8 kg m2 (github.com/utiasDSL/drone-models, cf21B_500), the motor's bell adds
  // to it; on slow flights feedback hides a part of both
  EXPECT_GT(inertia->parameters[0].value, 3.0e-8);
  EXPECT_LT(inertia->parameters[0].value, 9.0e-8);
  for (const ChannelFit& c : d->fit.held_out) {
    if (c.channel == "Mz") {
      EXPECT_GT(c.r2_after, c.r2_before + 0.4) << c.recording;
    }
  }
}

TEST(RealFlights, SpinUpExplainsTheYawOfQuickFlights) {
  if (!std::filesystem::exists(flights() / "crazyflie_brushless/eckart30"))
    GTEST_SKIP() << "no recordings at " << flights() << "; set OMNIFLIGHT_REAL_DATA";
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto v = vehicle::load_vehicle("crazyflie_brushless");
  ASSERT_TRUE(v) << v.error().text();
  const std::string f = "crazyflie_brushless/eckart";
  Options o;
  o.rollouts = false;
  const auto d = diagnose(load_all({f + "12", f + "17", f + "22", f + "27", f + "30"}),
                          load_all({f + "13", f + "18", f + "23", f + "24", f + "28"}), *v, o);
  ASSERT_TRUE(d) << d.error().text();
  const auto inertia = std::find_if(d->findings.begin(), d->findings.end(),
                                    [](const Finding& x) { return x.effect == "rotor_inertia"; });
  ASSERT_NE(inertia, d->findings.end()) << d->summary;
  EXPECT_GT(inertia->parameters[0].value, 5e-8);
  EXPECT_LT(inertia->parameters[0].value, 9e-8);
  // R2 over all flights that were not fitted: what is left and what was to be explained, both summed
  double all = 0, before = 0, after = 0;
  for (const ChannelFit& c : d->fit.held_out) {
    if (c.channel != "Mz") continue;
    const double variance = c.rms_after * c.rms_after / (1 - c.r2_after);
    all += variance;
    before += variance * (1 - c.r2_before);
    after += variance * (1 - c.r2_after);
  }
  RecordProperty("yaw_r2_before", std::to_string(1 - before / all));
  RecordProperty("yaw_r2_after", std::to_string(1 - after / all));
  EXPECT_LT(1 - before / all, 0.4);
  EXPECT_GE(1 - after / all, 0.8);
}

TEST(RealFlights, AStuckSpeedSensorIsNamed) {
  if (!std::filesystem::exists(flights() / "crazyflie_brushed/jana20"))
    GTEST_SKIP() << "no recordings at " << flights() << "; set OMNIFLIGHT_REAL_DATA";
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  const auto v = vehicle::load_vehicle("crazyflie_brushed");
  ASSERT_TRUE(v) << v.error().text();
  const auto good = load_all({"crazyflie_brushed/jana00"}), bad = load_all({"crazyflie_brushed/jana20"});
  ASSERT_EQ(good.size() + bad.size(), 2u);
  Options options;
  const auto faults = [&](const recording::Recording& r) {
    const auto f = prepare_flight(r, *v, options);
    return f ? f->faults.size() : std::size_t{99};
  };
  EXPECT_EQ(faults(good[0]), 0u);
  EXPECT_GE(faults(bad[0]), 1u);
}

}  // namespace
}  // namespace omniflight::diagnosis
