#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <fstream>

#include "omniflight_core/random.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/map.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "omniflight_planning/test_bed.hpp"

namespace omniflight::planning {
namespace {

const std::filesystem::path kBeds = std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT) / "configs/test_beds";

std::string good_map() {
  octomap::OcTree tree(0.1);
  tree.updateNode(octomap::point3d(0.25f, 0.35f, 0.45f), true);
  tree.updateNode(octomap::point3d(-0.25f, 0.15f, 0.05f), false);
  return octree_bytes(tree).value();
}
std::string header(const std::string& id, const std::string& size, const std::string& res) {
  return "# Octomap OcTree binary file\nid " + id + "\nsize " + size + "\nres " + res + "\ndata\n";
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(OctreeFile, HostileMapsAreRefusedWithAReason) {
  const std::string good = good_map();
  ASSERT_TRUE(scan_octree(good, "good.bt"));
  const std::string size = std::to_string(scan_octree(good, "good.bt")->nodes);
  std::string chain = header("OcTree", "100001", "0.1");
  for (int i = 0; i < 100000; ++i) chain += std::string("\x03\x00", 2);
  std::string seventeen = header("OcTree", "18", "0.1");  // 17 inner nodes under the root: leaves on level 18
  for (int i = 0; i < 17; ++i) seventeen += std::string("\x03\x00", 2);
  seventeen += std::string("\x02\x00", 2);
  const struct {
    const char* what;
    std::string bytes, reason;
  } cases[] = {
      {"cut by one byte", good.substr(0, good.size() - 1), "ends in the middle"},
      {"half", good.substr(0, good.size() - 20), "ends in the middle"},
      {"one byte more", good + "x", "follow the last node"},
      {"size 0", replaced(good, "size " + size, "size 0"), "empty"},
      {"size -5", replaced(good, "size " + size, "size -5"), "not a count"},
      {"size too large", replaced(good, "size " + size, "size 9999"), "header says"},
      {"size beyond the cap", replaced(good, "size " + size, "size 99999999999"), "limit"},
      {"size too small", replaced(good, "size " + size, "size 3"), "more nodes"},
      {"res 0", replaced(good, "res 0.1", "res 0"), "outside"},
      {"res -1", replaced(good, "res 0.1", "res -1"), "outside"},
      {"res nan", replaced(good, "res 0.1", "res nan"), "outside"},
      {"res inf", replaced(good, "res 0.1", "res inf"), "outside"},
      {"res 1e-300", replaced(good, "res 0.1", "res 1e-300"), "outside"},
      {"res 1e300", replaced(good, "res 0.1", "res 1e300"), "outside"},
      {"res abc", replaced(good, "res 0.1", "res abc"), "outside"},
      {"colour tree", replaced(good, "id OcTree", "id ColorOcTree"), "not OcTree"},
      {"no data", header("OcTree", "5", "0.1").substr(0, 40), "no 'data' line"},
      {"missing res", "# Octomap OcTree binary file\nid OcTree\nsize 5\ndata\n", "lacks"},
      {"long header", "# Octomap OcTree binary file\n#" + std::string(1 << 20, 'a'), "64 kB"},
      {"legacy", "1\x00\x00\x00", "no 'data' line"},
      {"other format", "\x89PNG\r\n\x1a\nxxxx\n", "not an OctoMap"},
      {"100000 deep", chain, "deeper"},
      {"17 levels", seventeen, "deeper"},
      {"only free space", header("OcTree", "2", "0.1") + std::string("\x01\x00", 2), "no occupied"},
      {"empty file", "", "no 'data' line"},
  };
  for (const auto& c : cases) {
    const auto result = scan_octree(c.bytes, "map.bt");
    ASSERT_FALSE(result) << c.what;
    EXPECT_NE(result.error().text().find(c.reason), std::string::npos)
        << c.what << ": " << result.error().text();
    EXPECT_NE(result.error().where.find("map.bt"), std::string::npos) << c.what;
  }
}

TEST(OctreeFile, RandomDamageNeverCrashesAndAcceptedMapsAgreeWithTheirHeader) {
  const std::string good = files::read_file(kBeds / "pyramid.bt", 1 << 20).value();
  Random random(5, "damage");
  int accepted = 0;
  for (int i = 0; i < 300; ++i) {
    std::string bytes = good;
    for (int k = 0; k < 3; ++k) bytes[random.next() % bytes.size()] = static_cast<char>(random.next());
    if (const auto scan = scan_octree(bytes, "x"); scan) {
      ++accepted;
      octomap::OcTree tree(scan->resolution);
      std::istringstream stream(bytes);
      ASSERT_TRUE(tree.readBinary(stream));
      EXPECT_EQ(tree.size(), scan->nodes);
    }
  }
  EXPECT_LT(accepted, 300);
}

TEST(DistanceTransform, EqualsBruteForceToVoxelBoxes) {
  const std::array<int, 3> size{13, 9, 11};
  Random random(1);
  std::vector<std::uint8_t> occupied(13 * 9 * 11, 0);
  for (auto& o : occupied) o = random.uniform() < 0.006;
  occupied[200] = 1;
  const float limit = 150.0f;
  const auto field = squared_distances_to_boxes(occupied, size, limit);
  const auto at = [&](int x, int y, int z) { return static_cast<std::size_t>((z * 9 + y) * 13 + x); };
  for (int z = 0; z < 11; ++z)
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 13; ++x) {
        float best = limit;
        for (int c = 0; c < 11; ++c)
          for (int b = 0; b < 9; ++b)
            for (int a = 0; a < 13; ++a) {
              if (!occupied[at(a, b, c)]) continue;
              const auto gap = [](int d) { return static_cast<float>(std::max(0, 2 * std::abs(d) - 1)); };
              best =
                  std::min(best, gap(x - a) * gap(x - a) + gap(y - b) * gap(y - b) + gap(z - c) * gap(z - c));
            }
        ASSERT_EQ(field[at(x, y, z)], best) << x << ' ' << y << ' ' << z;
      }
}

TEST(DistanceMap, IsALowerBoundOfTheDistanceToEveryOccupiedBox) {
  const auto file = read_octree(kBeds / "pyramid.bt").value();
  const auto map = DistanceMap::create(*file.tree, file.sha256).value();
  std::vector<std::pair<Vec3, double>> boxes;
  for (auto leaf = file.tree->begin_leafs(); leaf != file.tree->end_leafs(); ++leaf)
    if (file.tree->isNodeOccupied(*leaf))
      boxes.emplace_back(Vec3(leaf.getX(), leaf.getY(), leaf.getZ()), 0.5 * leaf.getSize());
  Random random(2);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p(random.uniform(-3.4, 3.4), random.uniform(-3.4, 3.4), random.uniform(0.0, 3.9));
    double exact = map.max_distance();
    for (const auto& [center, half] : boxes)
      exact = std::min(exact, ((p - center).cwiseAbs().array() - half).max(0.0).matrix().norm());
    EXPECT_LE(map.distance(p), exact + 1e-9);
    const double edge = std::min((p - map.lower()).minCoeff(), (map.upper() - p).minCoeff());
    worst = std::max(worst, std::min(exact, edge) - map.distance(p));
  }
  EXPECT_LT(worst, 0.87 * map.resolution());
  EXPECT_EQ(map.distance(Vec3(NAN, 0, 1)), 0.0);
  EXPECT_EQ(map.distance(Vec3(0, 0, 40)), 0.0);
}

TEST(DistanceMap, UnknownSpaceFollowsThePolicy) {
  octomap::OcTree tree(0.1);
  tree.updateNode(octomap::point3d(0.05f, 0.05f, 0.05f), true);
  tree.updateNode(octomap::point3d(1.05f, 1.05f, 1.05f), false);
  const Vec3 unknown(0.55, 0.55, 0.55);
  const auto strict = DistanceMap::create(tree, "", {.unknown = UnknownSpace::occupied}).value();
  const auto loose = DistanceMap::create(tree, "", {.unknown = UnknownSpace::free}).value();
  EXPECT_EQ(strict.distance(unknown), 0.0);
  EXPECT_GT(loose.distance(unknown), 0.3);
}

TEST(TestBed, CommittedMapIsTheOneItsDescriptionMakes) {
  const auto bed = load_test_bed(kBeds / "pyramid.yaml");
  ASSERT_TRUE(bed) << bed.error().text();
  const auto tree = make_octree(*bed).value();
  EXPECT_EQ(octree_bytes(*tree).value(), files::read_file(kBeds / "pyramid.bt", 1 << 20).value());
  // No point of a solid lies in a voxel that the map calls free.
  Random random(3);
  int inside = 0;
  for (int i = 0; i < 400000; ++i) {
    const Vec3 p(random.uniform(-1.6, 1.6), random.uniform(-1.6, 1.6), random.uniform(0.0, 3.1));
    const Primitive& solid = bed->nearest(p);
    if (solid.distance(p) > 0.0) continue;
    ++inside;
    const auto* node = tree->search(p.x(), p.y(), p.z());
    ASSERT_TRUE(node && tree->isNodeOccupied(node)) << solid.name << ' ' << p.transpose();
  }
  EXPECT_GT(inside, 100);
}

TEST(TestBed, UnknownKeysAreRefusedWithFileAndLine) {
  const auto path = std::filesystem::path(testing::TempDir()) / "bed.yaml";
  std::ofstream(path) << "schema: omniflight.test_bed/1\nname: x\nresolutoin: 0.1\n"
                         "bounds: {min: [0, 0, 0], max: [1, 1, 1]}\n"
                         "primitives:\n  - {name: a, kind: box, center: [0, 0, 0], size: [1, 1, 1]}\n";
  const auto bed = load_test_bed(path);
  ASSERT_FALSE(bed);
  EXPECT_NE(bed.error().text().find("bed.yaml:3"), std::string::npos) << bed.error().text();
  EXPECT_NE(bed.error().text().find("resolution"), std::string::npos) << bed.error().text();
}

}  // namespace
}  // namespace omniflight::planning
