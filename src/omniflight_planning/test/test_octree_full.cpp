// Maps in OctoMap's full format (.ot): the same map as .bt, and hostile files.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cstring>
#include <sstream>

#include "missions.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/plan.hpp"
#include "repetitions.hpp"

namespace omniflight::planning {
namespace {

std::string ot_bytes(const octomap::OcTree& tree) {
  std::ostringstream out;
  out << "# Octomap OcTree file\n# a comment\n#\nid OcTree\nsize " << tree.size() << "\nres "
      << tree.getResolution() << "\ndata\n";
  tree.writeData(out);
  return out.str();
}

/// Free and occupied voxels with probabilities that differ, inner nodes with what OctoMap gives them.
octomap::OcTree measured() {
  octomap::OcTree tree(0.1);
  Random random(1);
  for (int i = 0; i < 400; ++i) {
    const octomap::point3d p(static_cast<float>(random.uniform(-0.5, 0.5)),
                             static_cast<float>(random.uniform(-0.5, 0.5)),
                             static_cast<float>(random.uniform(0, 1)));
    tree.updateNode(p, p.z() < 0.4f);
  }
  return tree;
}

std::string node(float log_odds, unsigned children) {
  std::string out(5, '\0');
  std::memcpy(out.data(), &log_odds, 4);
  out[4] = static_cast<char>(children);
  return out;
}
std::string header(const std::string& size) {
  return "# Octomap OcTree file\nid OcTree\nsize " + size + "\nres 0.1\ndata\n";
}

TEST(FullOctree, IsTheSameMapAsItsBinaryForm) {
  const octomap::OcTree tree = measured();
  std::ostringstream whole;
  ASSERT_TRUE(tree.write(whole));  // as OctoMap itself writes a file
  for (const std::string& bytes : {whole.str(), ot_bytes(tree)}) {
    const auto read = octree_of(bytes, "map.ot");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(octree_bytes(**read).value(), octree_bytes(tree).value());
  }
}

TEST(FullOctree, AMissionOnTheTestBedAsOtIsPlannedAndVerifiedAsOnBt) {
  use_shipped_configs();
  const auto file = read_octree(kConfigs / "test_beds/pyramid.bt").value();
  written("pyramid_full.ot", ot_bytes(*file.tree));
  std::string yaml = trajectory_2_with("");
  const auto at = yaml.find("test_bed: pyramid");
  ASSERT_NE(at, std::string::npos);
  yaml.replace(at, 17, "test_bed: pyramid_full.ot");
  const auto mission = mission_of(yaml, "on_ot");
  ASSERT_TRUE(mission) << mission.error().text();
  const auto plan = plan_mission(*mission), same = plan_mission(load_mission("trajectory_2").value());
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_EQ(plan->certificate.min_clearance, same->certificate.min_clearance);
  EXPECT_EQ(plan->certificate.duration, same->certificate.duration);
  EXPECT_NE(plan->certificate.map_sha256, same->certificate.map_sha256);
  const auto dir = std::filesystem::path(testing::TempDir()) / "on_ot";
  ASSERT_TRUE(write_plan(*plan, dir));
  const auto report = verify(dir);
  EXPECT_TRUE(report) << report.error().text();
}

TEST(FullOctree, InnerNodesSayNothing) {
  // the root says free, of its two children one is occupied
  const auto tree = octree_of(header("3") + node(-5, 0x81) + node(2, 0) + node(-1, 0), "map.ot");
  ASSERT_TRUE(tree) << tree.error().text();
  EXPECT_TRUE((*tree)->isNodeOccupied((*tree)->getRoot()));
  const auto even = octree_of(header("1") + node(0, 0), "map.ot");  // probability 0.5: an obstacle
  ASSERT_TRUE(even) << even.error().text();
  EXPECT_TRUE((*even)->isNodeOccupied((*even)->getRoot()));
}

TEST(FullOctree, HostileFilesAreRefusedWithAReason) {
  std::string chain = header("100"), seventeen = header("18");
  for (int i = 0; i < 99; ++i) chain += node(1, 1);
  for (int i = 0; i < 17; ++i) seventeen += node(1, 1);
  const struct {
    const char* what;
    std::string bytes, reason;
  } cases[] = {{"no node", header("1"), "ends in the middle"},
               {"size 0", header("0") + node(1, 0), "empty"},
               {"size beyond the cap", header("2000000") + node(1, 0), "limit"},
               {"a child too few", header("3") + node(1, 3) + node(1, 0), "ends in the middle"},
               {"a child too many", header("2") + node(1, 3) + node(1, 0) + node(1, 0), "more nodes"},
               {"size too large", header("3") + node(1, 1) + node(1, 0), "header says 3"},
               {"a byte more", header("1") + node(1, 0) + "x", "follow the last node"},
               {"not a number", header("1") + node(NAN, 0), "not finite"},
               {"infinite", header("2") + node(1, 1) + node(HUGE_VALF, 0), "not finite"},
               {"nothing occupied", header("2") + node(1, 1) + node(-1, 0), "no occupied"},
               {"nodes without an end", chain, "deeper"},
               {"17 levels", seventeen + node(1, 0), "deeper"},
               {"another kind", "# Octomap OcTree file\nid ColorOcTree\nsize 1\nres 0.1\ndata\n" + node(1, 0),
                "not OcTree"},
               {"binary nodes", header("9") + std::string("\xaa\xaa", 2), "ends in the middle"}};
  for (const auto& c : cases) {
    const auto refused = octree_of(c.bytes, "map.ot");
    ASSERT_FALSE(refused) << c.what;
    EXPECT_NE(refused.error().text().find(c.reason), std::string::npos)
        << c.what << ": " << refused.error().text();
    EXPECT_FALSE(refused.error().next_step.empty()) << c.what;
  }
}

TEST(FullOctree, EveryTruncationIsRefused) {
  const std::string good = ot_bytes(measured());
  ASSERT_TRUE(octree_of(good, "map.ot"));
  for (std::size_t length = 0; length < good.size(); ++length)
    ASSERT_FALSE(octree_of(good.substr(0, length), "map.ot")) << length << " of " << good.size() << " bytes";
}

TEST(FullOctree, AFlippedBitIsRefusedOrGivesAMapWithinItsHeader) {
  const std::string good = ot_bytes(measured());
  const auto nodes = scan_octree(good, "map.ot")->nodes;
  std::size_t refused = 0;
  // one or two bits of every byte; every bit in the long tests
  const std::size_t step = times() > 1 ? 1 : 5;
  for (std::size_t bit = 0; bit < 8 * good.size(); bit += step) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << (bit % 8)));
    const auto tree = octree_of(bad, "map.ot");
    refused += !tree;
    if (tree) {
      EXPECT_LE((*tree)->size(), nodes) << bit;
    } else {
      EXPECT_FALSE(tree.error().message.empty()) << bit;
    }
  }
  EXPECT_GT(refused, good.size() / step);  // of eight times as many
}

}  // namespace
}  // namespace omniflight::planning
