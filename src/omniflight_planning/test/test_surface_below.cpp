// Where a descent onto a map ends. All maps are made here.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/surface_below.hpp"
#include "omniflight_planning/test_bed.hpp"

namespace omniflight::planning {
namespace {

const std::filesystem::path kBeds = std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT) / "configs/test_beds";

/// A room of 2 x 2 x 2 m with a floor at 0, a table of 0.6 m with free space under it, and a post beside it.
std::shared_ptr<const octomap::OcTree> room() {
  TestBed bed;
  bed.name = "room";
  bed.resolution = 0.05;
  bed.lower = Vec3(-1, -1, -0.1);
  bed.upper = Vec3(1, 1, 2);
  const auto box = [&](const Vec3& center, const Vec3& size) {
    bed.primitives.push_back({Primitive::Kind::box, "solid", center, size, 0.0});
  };
  box(Vec3(0, 0, -0.05), Vec3(1.98, 1.98, 0.08));
  box(Vec3(0.5, 0, 0.575), Vec3(0.48, 0.48, 0.04));
  box(Vec3(-0.525, 0.025, 0.75), Vec3(0.04, 0.04, 1.48));
  return make_octree(bed).value();
}

VehicleSpheres ball(double radius, const Vec3& at = Vec3::Zero()) {
  VehicleSpheres out;
  out.groups.push_back({{at, radius}, {{at, radius}}, {}});
  return out;
}

TEST(SurfaceBelow, TheTopBelowAPointIsThatOfTheNextSolid) {
  const auto surface = SurfaceBelow::create(*room()).value();
  EXPECT_NEAR(surface.top_below(Vec3(0.5, 0, 1.5)).value(), 0.6, 1e-9) << "the table";
  EXPECT_NEAR(surface.top_below(Vec3(0.5, 0, 0.3)).value(), 0.0, 1e-9) << "the floor under the table";
  EXPECT_NEAR(surface.top_below(Vec3(-0.1, 0, 1.5)).value(), 0.0, 1e-9) << "beside it";
  EXPECT_NEAR(surface.top_below(Vec3(-0.525, 0.025, 1.9)).value(), 1.5, 1e-9) << "the post";
  EXPECT_NEAR(surface.top_below(Vec3(0.5, 0, 50)).value(), 0.6, 1e-9) << "from above the map";
  EXPECT_FALSE(surface.top_below(Vec3(-0.525, 0.025, 0.7))) << "in the post, which stands on the floor";
  EXPECT_FALSE(surface.top_below(Vec3(0.5, 0, -3)));
  EXPECT_FALSE(surface.top_below(Vec3(1.5, 0, 1)));
  for (const double broken : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    EXPECT_FALSE(surface.top_below(Vec3(broken, 0, 1)));
    EXPECT_FALSE(surface.top_below(Vec3(0, 0, broken)));
  }
}

TEST(SurfaceBelow, AVehicleLandsWithItsLowestPartOnTheHighestSolidUnderIt) {
  const auto surface = SurfaceBelow::create(*room()).value();
  const auto on_table = surface.landing({Vec3(0.5, 0, 1.5), Quat::Identity()}, ball(0.1));
  ASSERT_TRUE(on_table);
  EXPECT_NEAR(on_table->p_z, 0.7, 1e-9);
  EXPECT_NEAR(on_table->surface_z, 0.6, 1e-9);
  // the centre is beside the table, the rim is above its edge at x = 0.25
  const auto on_edge = surface.landing({Vec3(0.19, 0, 1.5), Quat::Identity()}, ball(0.1));
  ASSERT_TRUE(on_edge);
  EXPECT_NEAR(on_edge->p_z, 0.6 + std::sqrt(0.01 - 0.06 * 0.06), 1e-6);
  EXPECT_NEAR(surface.landing({Vec3(0.1, 0, 1.5), Quat::Identity()}, ball(0.1))->p_z, 0.1, 1e-9);
  // a part 0.3 m along x hangs down in this attitude
  const Quat nose_down(Eigen::AngleAxisd(kPi / 2, Vec3::UnitY()));
  EXPECT_NEAR(surface.landing({Vec3(0.5, 0, 1.5), nose_down}, ball(0.1, Vec3(0.3, 0, 0)))->p_z, 1.0, 1e-6);
}

TEST(SurfaceBelow, WhatStandsBesideIsNotBelow) {
  const auto surface = SurfaceBelow::create(*room()).value();
  const auto beside = surface.landing({Vec3(-0.43, 0, 1.0), Quat::Identity()}, ball(0.1));
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->surface_z, 0.0, 1e-9) << "the rim is in the post, which goes past it";
}

TEST(SurfaceBelow, NothingBelowAndNumbersThatAreNoneAreNoLanding) {
  const auto surface = SurfaceBelow::create(*room()).value();
  EXPECT_FALSE(surface.landing({Vec3(5, 5, 1), Quat::Identity()}, ball(0.1)));
  EXPECT_FALSE(surface.landing({Vec3(NAN, 0, 1), Quat::Identity()}, ball(0.1)));
  EXPECT_FALSE(surface.landing({Vec3(0, 0, 1), Quat::Identity()}, ball(NAN)));
  EXPECT_TRUE(surface.landing({Vec3(1e6, 0, 1), Quat::Identity()}, ball(1e7)).has_value());
}

/// By definition: a sphere moved down in steps until a solid voxel below its centre is in it.
TEST(SurfaceBelow, AgreesWithMovingDownInSteps) {
  const auto tree = room();
  const auto surface = SurfaceBelow::create(*tree).value();
  const auto occupied = [&](double x, double y, double z) {
    const auto* node = tree->search(x, y, z);
    return node != nullptr && tree->isNodeOccupied(node);
  };
  Random random(3);
  int landed = 0;
  for (int k = 0; k < 60; ++k) {
    const double r = random.uniform(0.03, 0.2);
    const Vec3 p(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 1.8);
    const auto found = surface.landing({p, Quat::Identity()}, ball(r));
    ASSERT_TRUE(found);
    double z = p.z();
    const auto touches = [&] {
      const int at_x = static_cast<int>(std::floor(p.x() / 0.05)),
                at_y = static_cast<int>(std::floor(p.y() / 0.05));
      for (int x = at_x - 5; x <= at_x + 5; ++x)
        for (int y = at_y - 5; y <= at_y + 5; ++y)
          for (int down = 0; down < 5; ++down) {
            const double low_x = 0.05 * x, low_y = 0.05 * y;
            const double voxel_z = 0.05 * (std::floor(z / 0.05) - 1 - down);
            if (voxel_z + 0.05 < z - r) break;
            const Vec3 near(std::clamp(p.x(), low_x, low_x + 0.05), std::clamp(p.y(), low_y, low_y + 0.05),
                            std::clamp(z, voxel_z, voxel_z + 0.05));
            if ((near - Vec3(p.x(), p.y(), z)).norm() < r &&
                occupied(low_x + 0.025, low_y + 0.025, voxel_z + 0.025))
              return true;
          }
      return false;
    };
    while (z > 0 && !touches()) z -= 0.002;
    EXPECT_NEAR(found->p_z, z, 0.0025) << p.transpose() << ", radius " << r;
    landed += found->surface_z > 0.1;
  }
  EXPECT_GT(landed, 5) << "some of them on the table or the post";
}

TEST(SurfaceBelow, MapsThatAreNoneAreRefused) {
  EXPECT_EQ(SurfaceBelow::create(octomap::OcTree(0.1)).error().code, ErrorCode::bad_input);
  octomap::OcTree free_space(0.1);
  free_space.updateNode(octomap::point3d(0.25f, 0.35f, 0.45f), false);
  EXPECT_NE(SurfaceBelow::create(free_space).error().message.find("no occupied voxel"), std::string::npos);
  const auto missing = SurfaceBelow::load("no_such.bt");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().text().find("no_such.bt"), std::string::npos);
}

TEST(SurfaceBelow, TheShippedBedHasACounterUnderItsFrame) {
  const auto surface = SurfaceBelow::load(kBeds / "pyramid.bt");
  ASSERT_TRUE(surface) << surface.error().text();
  EXPECT_NEAR(surface->top_below(Vec3(0.1, 0.1, 1.3)).value(), 0.6, 1e-6);
  EXPECT_NEAR(surface->top_below(Vec3(0, 2.6, 1.3)).value(), 0.75, 1e-6);
  EXPECT_NEAR(surface->top_below(Vec3(3, 3, 1.3)).value(), 0.0, 1e-6);
}

}  // namespace
}  // namespace omniflight::planning
