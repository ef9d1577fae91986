// Rotor commands, headroom and clearance of a plan's knots, and trajectory.csv.
#include <gtest/gtest.h>

#include <sstream>

#include "missions.hpp"
#include "omniflight_planning/payload.hpp"
#include "omniflight_planning/plan.hpp"

namespace omniflight::planning {
namespace {

Mission tilting() {
  Mission mission;
  mission.name = "tilting";
  mission.alpha = to_radians(45);
  mission.payload = Payload{.mass = 0.1, .p_B = Vec3(0.02, 0, 0)};
  mission.waypoints = {{.name = "start", .pose = {Vec3(0, 0, 1.2), Quat::Identity()}, .where = {}},
                       {.name = "aside",
                        .pose = {Vec3(0.2, 0.1, 1.4), from_roll_pitch_yaw(Vec3(0.5, 0, 0))},
                        .hold_s = 0.1,
                        .where = {}}};
  return mission;
}

PlanOptions with_figures() {
  PlanOptions options;
  options.figures = true;
  return options;
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out;
  std::istringstream in(line + ',');
  for (std::string cell; std::getline(in, cell, ',');) out.push_back(cell);
  return out;
}

TEST(KnotFigures, ThrustsGiveTheMotionsWrenchAndHeadroomIsTheCertificates) {
  const Mission mission = tilting();
  const auto made = plan(mission, omnimorph(), pyramid(), with_figures());
  ASSERT_TRUE(made) << made.error().text();
  const auto& knots = made->trajectory.knots();
  ASSERT_EQ(made->figures.size(), knots.size());
  const auto loaded = carrying(omnimorph(), *mission.payload);
  const auto rotors = rotor_load(loaded, to_radians(45));
  const auto B = loaded.allocation_matrix(to_radians(45));
  double least = 1.0;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const KnotFigures& f = made->figures[k];
    EXPECT_LT((B * f.thrusts - rotors.required_wrench(knots[k].reference)).norm(), 1e-4) << knots[k].t;
    EXPECT_TRUE((f.thrusts.array() >= loaded.lower_thrusts().array() - 1e-9).all());
    EXPECT_TRUE((f.thrusts.array() <= loaded.upper_thrusts().array() + 1e-9).all());
    EXPECT_GE(f.clearance, mission.clearance);
    least = std::min(least, f.headroom);
  }
  EXPECT_NEAR(least, 1.0 - made->certificate.peak.rotor_load, 1e-12);
}

TEST(KnotFigures, TheTableHasThemWithUnitsAndItsJerkIsTheRateOfTheAcceleration) {
  const auto made = plan(tilting(), omnimorph(), pyramid(), with_figures());
  ASSERT_TRUE(made) << made.error().text();
  const auto dir = std::filesystem::path(testing::TempDir()) / "knot_figures";
  ASSERT_TRUE(write_plan(*made, dir));
  std::istringstream in(files::read_file(dir / "trajectory.csv", 10 << 20).value());
  std::string line;
  std::getline(in, line);
  const auto header = cells(line);
  ASSERT_EQ(header.size(), 24u + 8u + 2u);
  EXPECT_EQ(header[21], "ref_jx_mps3");
  EXPECT_EQ(header[24], "u1_N");
  EXPECT_EQ(header[32], "clearance_m");
  EXPECT_EQ(header[33], "headroom");
  const auto& knots = made->trajectory.knots();
  for (std::size_t k = 0; std::getline(in, line); ++k) {
    const auto row = cells(line);
    ASSERT_EQ(row.size(), header.size()) << line;
    EXPECT_NEAR(std::stod(row[32]), made->figures[k].clearance, 1e-5);
    if (k + 1 == knots.size()) continue;
    const double e = 1e-4;  // s
    const Vec3 rate = (made->trajectory.sample(knots[k].t + e).a_WB_W - knots[k].reference.a_WB_W) / e;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::stod(row[static_cast<std::size_t>(21 + i)]), rate[i], 0.05);
  }
}

TEST(KnotFigures, APlanThatNobodyAskedForThemHasNone) {
  const auto made = plan(tilting(), omnimorph(), pyramid());
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_TRUE(made->figures.empty());
}

}  // namespace
}  // namespace omniflight::planning
