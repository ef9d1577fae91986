#include "omniflight_planning/test_bed.hpp"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>

#include "omniflight_files/yaml.hpp"

namespace omniflight::planning {
namespace {

constexpr double kMaxVoxels = 10e6;       // as octree_file.hpp reads
constexpr double kFarthestInBed = 100.0;  // m

double segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = d.squaredNorm() > 0.0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - (a + t * d)).norm();
}

double cube_distance(const Vec3& p, const Vec3& center, double half) {
  return ((p - center).cwiseAbs().array() - half).max(0.0).matrix().norm();
}

/// Least distance of a segment to a cube: convex along the segment, so a ternary search finds it.
double segment_cube_distance(const Vec3& a, const Vec3& b, const Vec3& center, double half) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 48; ++i) {
    const double t1 = low + (high - low) / 3.0, t2 = high - (high - low) / 3.0;
    if (cube_distance(a + t1 * (b - a), center, half) <= cube_distance(a + t2 * (b - a), center, half))
      high = t2;
    else
      low = t1;
  }
  return cube_distance(a + 0.5 * (low + high) * (b - a), center, half);
}

Primitive capsule(std::string name, const Vec3& from, const Vec3& to, double radius) {
  return {.kind = Primitive::Kind::capsule, .name = std::move(name), .a = from, .b = to, .radius = radius};
}

/// Four beams on the ground, four to the apex. The capsule holds the square profile.
void add_pyramid(files::YamlReader frame, std::vector<Primitive>& out) {
  const std::string name = frame.string("name");
  const Vec3 center = frame.vec3("center", files::between(-kFarthestInBed, kFarthestInBed, "m"));
  const double half = 0.5 * frame.number("base", files::between(0.1, kFarthestInBed, "m"));
  const double apex = frame.number("apex", files::between(0.1, kFarthestInBed, "m"));
  const double radius = std::sqrt(0.5) * frame.number("profile", files::between(1e-3, 1.0, "m"));
  const Vec3 corners[] = {{half, half, 0}, {-half, half, 0}, {-half, -half, 0}, {half, -half, 0}};
  for (int k = 0; k < 4; ++k) {
    const std::string number = std::to_string(k + 1);
    out.push_back(
        capsule(name + " ground beam " + number, center + corners[k], center + corners[(k + 1) % 4], radius));
    out.push_back(capsule(name + " beam " + number, center + corners[k], center + Vec3(0, 0, apex), radius));
  }
}

}  // namespace

Primitive read_primitive(files::YamlReader& item) {
  using Kind = Primitive::Kind;
  const auto place = files::between(-kFarthestInBed, kFarthestInBed, "m");
  const auto length = files::between(1e-3, kFarthestInBed, "m");
  Primitive p;
  p.name = item.string("name");
  p.kind = item.choice<Kind>("kind",
                             {{"box", Kind::box}, {"capsule", Kind::capsule}, {"cylinder", Kind::cylinder}});
  switch (p.kind) {
    case Kind::box:
      p.a = item.vec3("center", place);
      p.b = item.vec3("size", length);
      break;
    case Kind::capsule:
      p.a = item.vec3("from", place);
      p.b = item.vec3("to", place);
      p.radius = item.number("radius", length);
      break;
    case Kind::cylinder:
      p.a = item.vec3("base", place);
      p.b = p.a + Vec3(0, 0, item.number("height", length));
      p.radius = item.number("radius", length);
      break;
  }
  return p;
}

std::array<Vec3, 2> Primitive::box() const {
  switch (kind) {
    case Kind::box:
      return {a - 0.5 * b, a + 0.5 * b};
    case Kind::capsule:
      return {a.cwiseMin(b) - Vec3::Constant(radius), a.cwiseMax(b) + Vec3::Constant(radius)};
    case Kind::cylinder: {
      const Vec3 across(radius, radius, 0.0);
      return {a - across, b + across};
    }
  }
  return {a, b};
}

double Primitive::distance(const Vec3& p) const {
  switch (kind) {
    case Kind::box:
      return ((p - a).cwiseAbs() - 0.5 * b).cwiseMax(0.0).norm();
    case Kind::capsule:
      return std::max(0.0, segment_distance(p, a, b) - radius);
    case Kind::cylinder: {
      const double out = std::max(0.0, (p - a).head<2>().norm() - radius);
      const double above = std::max({0.0, a.z() - p.z(), p.z() - b.z()});
      return std::hypot(out, above);
    }
  }
  return 0.0;
}

bool Primitive::touches_cube(const Vec3& center, double half) const {
  constexpr double slack = 1e-7;  // touching counts as contact in spite of rounding
  switch (kind) {
    case Kind::box:
      return ((a - center).cwiseAbs().array() <= 0.5 * b.array() + half + slack).all();
    case Kind::capsule:
      return segment_cube_distance(a, b, center, half) <= radius + slack;
    case Kind::cylinder: {
      const Eigen::Array2d gap = ((a - center).head<2>().cwiseAbs().array() - half).max(0.0);
      return gap.matrix().norm() <= radius + slack && center.z() + half + slack >= a.z() &&
             center.z() - half - slack <= b.z();
    }
  }
  return true;
}

const Primitive& TestBed::nearest(const Vec3& p) const {
  return *std::min_element(primitives.begin(), primitives.end(), [&](const Primitive& l, const Primitive& r) {
    return l.distance(p) < r.distance(p);
  });
}

Result<TestBed> load_test_bed(const std::filesystem::path& path) {
  auto root = files::YamlReader::load(path);
  if (!root) return Failure(root.error());
  TestBed bed;
  if (const std::string schema = root->string("schema"); root->ok() && schema != "omniflight.test_bed/1")
    root->error_at("schema", "schema is '" + schema + "'", "Write omniflight.test_bed/1");
  bed.name = root->string("name");
  root->string("notes", "");
  bed.resolution = root->number("resolution", files::between(0.005, 1.0, "m"), 0.05);
  auto bounds = root->child("bounds");
  bed.lower = bounds.vec3("min", files::between(-kFarthestInBed, kFarthestInBed, "m"));
  bed.upper = bounds.vec3("max", files::between(-kFarthestInBed, kFarthestInBed, "m"));
  bed.ground_z = root->number("ground_z", files::between(-kFarthestInBed, kFarthestInBed, "m"), 0.0);
  if (root->ok() && (bed.ground_z < bed.lower.z() || bed.ground_z > bed.upper.z()))
    root->error_at("ground_z", "lies outside of the bounds", "Give a height [m] between min and max");
  const Vec3 cells = (bed.upper - bed.lower) / bed.resolution;
  if (root->ok() && (cells.minCoeff() < 1.0 || cells.prod() > kMaxVoxels))
    bounds.error("the box from min to max holds no voxel or more than 10 million of them",
                 "Correct min and max or use a coarser resolution");
  for (auto& frame : root->children("pyramids", 0, 100)) add_pyramid(frame, bed.primitives);
  for (auto& item : root->children("primitives", 0, 10000)) bed.primitives.push_back(read_primitive(item));
  if (root->ok() && bed.primitives.empty()) root->error("the test bed has neither pyramids nor primitives");
  if (auto ok = root->finish(); !ok) return Failure(ok.error());
  return bed;
}

Result<std::shared_ptr<const octomap::OcTree>> make_octree(const TestBed& bed) {
  auto tree = std::make_shared<octomap::OcTree>(bed.resolution);
  const double res = bed.resolution, half = 0.5 * res;
  octomap::OcTreeKey low, high;
  const auto point = [](const Vec3& p) {
    return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  };
  const Vec3 inset = Vec3::Constant(0.25 * res);
  if (bed.primitives.empty() || !tree->coordToKeyChecked(point(bed.lower + inset), low) ||
      !tree->coordToKeyChecked(point(bed.upper - inset), high))
    return bad_input("the bounds leave the range of an octree with this resolution", "test bed " + bed.name);
  const float occupied = tree->getClampingThresMaxLog(), free = tree->getClampingThresMinLog();
  octomap::OcTreeKey key;
  for (key[0] = low[0]; key[0] <= high[0]; ++key[0])
    for (key[1] = low[1]; key[1] <= high[1]; ++key[1])
      for (key[2] = low[2]; key[2] <= high[2]; ++key[2]) {
        const Vec3 center(tree->keyToCoord(key[0]), tree->keyToCoord(key[1]), tree->keyToCoord(key[2]));
        const bool full = std::any_of(bed.primitives.begin(), bed.primitives.end(), [&](const Primitive& p) {
          return p.distance(center) <= std::sqrt(3.0) * half + 1e-6 && p.touches_cube(center, half);
        });
        tree->setNodeValue(key, full ? occupied : free, true);
      }
  tree->updateInnerOccupancy();
  tree->toMaxLikelihood();
  tree->prune();
  return std::shared_ptr<const octomap::OcTree>(std::move(tree));
}

}  // namespace omniflight::planning
