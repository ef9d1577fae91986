// A test bed described by a few primitives, and the octree that is made from it.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"

namespace octomap {
class OcTree;
}
namespace omniflight::files {
class YamlReader;
}

namespace omniflight::planning {

/// A solid in the world frame.
struct Primitive {
  enum class Kind { box, capsule, cylinder } kind = Kind::box;
  std::string name;
  Vec3 a = Vec3::Zero();  ///< m; box: centre; capsule: one end; cylinder (upright): centre of the base
  Vec3 b =
      Vec3::Zero();     ///< m; box: full edges along x, y, z; capsule: other end; cylinder: centre of the top
  double radius = 0.0;  ///< m; capsule and cylinder

  double distance(const Vec3& p) const;  ///< m, from a point; 0 inside
  std::array<Vec3, 2> box() const;       ///< m, the corners of the axis-aligned box that holds it
  /// Whether the solid meets the axis-aligned cube with this centre and half edge [m]. Never misses a
  /// contact; beyond one it errs by at most 1e-6 m.
  bool touches_cube(const Vec3& center, double half) const;
};

struct TestBed {
  std::string name;
  double resolution = 0.05;   ///< m
  Vec3 lower = Vec3::Zero();  ///< m, the box that is known; free where no primitive is
  Vec3 upper = Vec3::Zero();  ///< m
  double ground_z = 0.0;      ///< m, where a descent ends
  std::vector<Primitive> primitives;

  /// The primitive nearest to p; there is always one.
  const Primitive& nearest(const Vec3& p) const;
};

/// One item of `primitives` in a test bed, or of `keep_out` in a mission.
Primitive read_primitive(files::YamlReader& item);

/// Reads schema omniflight.test_bed/1 (README.md lists its keys). Errors name file, line and field.
Result<TestBed> load_test_bed(const std::filesystem::path& path);

/// Marks each voxel that a primitive touches as occupied and every other one of the known box as free.
Result<std::shared_ptr<const octomap::OcTree>> make_octree(const TestBed& bed);

}  // namespace omniflight::planning
