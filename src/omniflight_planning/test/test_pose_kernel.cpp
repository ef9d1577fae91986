// Poses and motions against the field of a byte a voxel: on every instruction set, and beside the octree
// itself.
#include <gtest/gtest.h>

#include "../src/octree_boxes.hpp"
#include "bench.hpp"
#include "instruction_sets.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/zones.hpp"

namespace omniflight::planning {
namespace {

Pose any_pose(Random& random, const DistanceMap& map, double beyond) {
  Pose pose;
  for (int k = 0; k < 3; ++k) pose.p_WB[k] = random.uniform(map.lower()[k] - beyond, map.upper()[k] + beyond);
  pose.q_WB = Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
  return pose;
}

enum class Where { anywhere, in_window, by_shelf };

const Vec3 kShelf(1.2, -0.7, 1.1);  // m

/// Those in the window are ambiguous, those anywhere of every kind.
std::vector<Pose> poses_of(const DistanceMap& map, Where where, std::size_t count) {
  Random random(21);
  std::vector<Pose> out;
  while (out.size() < count) {
    Pose pose = any_pose(random, map, 0.2);
    if (where == Where::by_shelf)
      pose.p_WB = kShelf + 0.5 * Vec3(random.normal(), random.normal(), random.normal());
    if (where == Where::in_window) {
      pose.p_WB = kWindow + 0.04 * Vec3(2.0 * random.normal(), random.normal(), random.normal());
      pose.q_WB = exp_rotation(0.1 * Vec3(random.normal(), random.normal(), random.normal()));
    }
    out.push_back(pose);
  }
  return out;
}

TEST(PoseKernel, EveryInstructionSetGivesTheSameBits) {
  const DistanceMap window =
      DistanceMap::create(*make_octree(window_bed(0.5, 0.5, 0.02)).value(), "").value();
  for (const bool in_window : {true, false}) {
    const DistanceMap& map = in_window ? window : pyramid();
    const StateCheck check = make_check(map, 45, 0.01);
    const auto set = poses_of(map, in_window ? Where::in_window : Where::anywhere, 600);
    const auto answers = [&] {
      std::vector<double> out;
      for (std::size_t i = 0; i < set.size(); ++i) {
        out.push_back(check.room(set[i]));
        out.push_back(check.room(set[i], 0.05));
        out.push_back(check.clear(set[i]));
        if (i % 3 != 0) continue;
        Pose to = set[i];
        to.p_WB += Vec3(0.15, -0.1, 0.05);
        to.q_WB = (to.q_WB * exp_rotation(Vec3(0.1, 0.3, -0.2))).normalized();
        out.push_back(check.motion_valid(set[i], to));
      }
      return out;
    };
    const auto best = answers();
    EXPECT_GT(std::count_if(best.begin(), best.end(), [](double x) { return x > 0.0 && x < 0.03; }), 20);
    const int sets =
        test::for_each_instruction_set([&](const char* name) { EXPECT_EQ(answers(), best) << name; });
    EXPECT_GE(sets, 1);
  }
}

/// The octree's boxes are measured to every part in double precision, without any field.
void expect_what_the_boxes_say(const octomap::OcTree& tree, const DistanceMap& map, const Zones& zones,
                               Where where, std::size_t count) {
  constexpr double kMargin = 0.01, kMeasuredTo = 2.5e-4;
  OctreeBoxes boxes(tree, zones);
  const StateCheck check = make_check(map, 45, kMargin);
  std::size_t free_poses = 0, tight = 0, hit = 0;
  for (const Pose& pose : poses_of(map, where, count)) {
    const double truth = boxes.clearance(pose, check.spheres());
    const double room = check.room(pose);
    if (truth < kBoxHorizon) {
      ASSERT_LE(room, std::max(0.0, truth - kMargin + kMeasuredTo)) << pose.p_WB.transpose();
    }
    if (check.clear(pose)) {
      ASSERT_GE(truth, kMargin + StateCheck::kLeastRoom - kMeasuredTo);
      ++free_poses;
      tight += truth < kMargin + 0.015;
    } else {
      ASSERT_LE(truth, kMargin + StateCheck::kLeastRoom + kMeasuredTo) << pose.p_WB.transpose();
      ++hit;
    }
  }
  EXPECT_GT(free_poses, count / 20);
  EXPECT_GT(tight, 5u) << "free poses that spheres cannot tell";
  EXPECT_GT(hit, count / 20);
}

TEST(PoseKernel, TellsNoMoreThanTheOctreesBoxesAndLosesNoFreePose) {
  const auto bed = read_octree(kConfigs / "test_beds/pyramid.bt").value().tree;
  expect_what_the_boxes_say(*bed, pyramid(), {}, Where::anywhere, 1500);
  const auto window = make_octree(window_bed(0.5, 0.5, 0.02)).value();
  expect_what_the_boxes_say(*window, DistanceMap::create(*window, "").value(), {}, Where::in_window, 300);
}

TEST(PoseKernel, FollowsZonesThatAreClosedLater) {
  const auto bed = read_octree(kConfigs / "test_beds/pyramid.bt").value().tree;
  Zones zones;
  zones.keep_out.push_back({Primitive::Kind::box, "shelf", kShelf, Vec3(0.5, 0.9, 0.33), 0});
  DistanceMap map = DistanceMap::create(*bed, "").value();
  ASSERT_TRUE(map.close(zones));
  expect_what_the_boxes_say(*bed, map, zones, Where::by_shelf, 600);
  zones.keep_in = std::array{Vec3(-1.9, -1.8, 0.2), Vec3(1.7, 1.9, 2.4)};  // at faces of voxels
  ASSERT_TRUE(map.close(zones));
  expect_what_the_boxes_say(*bed, map, zones, Where::by_shelf, 600);
}

/// Room between two poses is what conservative advancement over room() leaves: whatever is accepted is free
/// at every pose, and what that accepts with a little more margin is not lost.
TEST(PoseKernel, MotionsAreFreeAtEveryPoseAndFewAreLost) {
  const StateCheck check = make_check(pyramid(), 45, 0.02), wider = check.with_margin(0.022);
  Random random(31);
  int accepted = 0, lost = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose a = any_pose(random, pyramid(), 0.0);
    const Pose b{
        a.p_WB + 0.3 * Vec3(random.normal(), random.normal(), random.normal()),
        (a.q_WB * exp_rotation(0.6 * Vec3(random.normal(), random.normal(), random.normal()))).normalized()};
    const bool is_free = check.motion_valid(a, b);
    accepted += is_free;
    double least = 1.0;
    bool held = true;
    for (int k = 0; k <= 200; ++k) {
      const Pose at = interpolate(a, b, k / 200.0);
      if (is_free) {
        ASSERT_GE(check.room(at), 0.0);
      }
      least = std::min(least, wider.room(at));
      held &= check.hoverable(at.q_WB);
      if (least <= 0.0 || !held) break;
    }
    lost += !is_free && least > 0.0 && held;
  }
  EXPECT_GT(accepted, 50);
  EXPECT_EQ(lost, 0);
}

TEST(PoseKernel, NothingBeyondTheNumbersOfAGridIsFree) {
  const StateCheck check = make_check(pyramid(), 45, 0.0);
  const Pose home{Vec3(0, 0, 1.4), Quat::Identity()};
  ASSERT_TRUE(check.valid(home));
  for (const double far : {1e3, 1e9, 1e30, 1e300, std::numeric_limits<double>::infinity(), std::nan("")})
    for (int k = 0; k < 3; ++k)
      for (const double side : {-1.0, 1.0}) {
        Pose pose = home;
        pose.p_WB[k] = side * far;
        EXPECT_FALSE(check.clear(pose));
        EXPECT_LE(check.room(pose), 0.0);
        EXPECT_FALSE(check.motion_valid(home, pose));
        EXPECT_FALSE(check.motion_valid(pose, home));
      }
}

}  // namespace
}  // namespace omniflight::planning
