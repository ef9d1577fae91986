// Every shipped vehicle gets a certified plan for a metre sideways and for a figure eight.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench.hpp"
#include "omniflight_allocation/actuation.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

std::vector<std::string> names() {
  setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1);
  return vehicle::vehicle_names();
}

/// The mission as it is shipped; for the widest vehicle, 1.2 m from rim to rim, with half its clearance.
std::string mission_of(const std::string& vehicle, const std::string& name) {
  if (vehicle != "coaxial_fam") return name;
  std::stringstream text;
  text << std::ifstream(kConfigs / "missions" / (name + ".yaml")).rdbuf();
  std::string closer = text.str();
  const std::string wide = "clearance_m: 0.10";
  const auto at = closer.find(wide);
  EXPECT_NE(at, std::string::npos);
  const auto file = std::filesystem::path(testing::TempDir()) / (name + "_closer.yaml");
  std::ofstream(file) << closer.replace(at, wide.size(), "clearance_m: 0.05");
  return file;
}

struct Shipped : testing::TestWithParam<std::string> {};

TEST_P(Shipped, PlansAndVerifies) {
  setenv("OMNIFLIGHT_CONFIGS", kConfigs.c_str(), 1);
  for (const char* mission_name : {"sideways", "figure_eight"}) {
    const auto mission = load_mission(mission_of(GetParam(), mission_name)).value();
    PlanOptions options;
    options.vehicle = GetParam();
    const auto plan = plan_mission(mission, options);
    ASSERT_TRUE(plan) << mission_name << ": " << plan.error().text();
    const Certificate& c = plan->certificate;
    EXPECT_LT(c.duration, 40.0) << mission_name;  // s
    const auto v = vehicle::load_vehicle(GetParam()).value();
    const auto here = allocation::actuation_at(v, c.alpha).value();
    EXPECT_EQ(c.leans, here.kind == allocation::ActuationKind::underactuated);
    const auto dir =
        std::filesystem::path(testing::TempDir()) / ("shipped_" + GetParam() + "_" + mission_name);
    ASSERT_TRUE(write_plan(*plan, dir));
    const auto report = verify(dir);
    ASSERT_TRUE(report) << mission_name << ": " << report.error().text();
    EXPECT_EQ(read_plan(dir).value().certificate.leans, c.leans);
  }
}

INSTANTIATE_TEST_SUITE_P(Vehicles, Shipped, testing::ValuesIn(names()), [](const auto& one) {
  std::string name = one.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

}  // namespace
}  // namespace omniflight::planning
