// What several tests share: the committed test bed and the shipped vehicle.
#pragma once

#include <octomap/OcTree.h>

#include <filesystem>

#include "omniflight_planning/map.hpp"
#include "omniflight_planning/state_check.hpp"
#include "omniflight_planning/test_bed.hpp"
#include "omniflight_planning/timing.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

inline const std::filesystem::path kConfigs = std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT) / "configs";

inline vehicle::Vehicle omnimorph() {
  return vehicle::load_vehicle((kConfigs / "vehicles/omnimorph/omnimorph.yaml").string()).value();
}
inline const DistanceMap& pyramid() {
  static const DistanceMap map = DistanceMap::load(kConfigs / "test_beds/pyramid.bt").value();
  return map;
}
/// A room of 4 x 3 x 2.4 m, cut in two by a wall of 0.1 m with a window about kWindow (m; width along y).
/// Faces lie a millimetre inside of the voxels' faces, so that the voxels leave exactly the window free.
inline const Vec3 kWindow(0.05, 0.0, 1.2);
inline TestBed window_bed(double width, double height, double resolution) {
  TestBed bed;
  bed.name = "window";
  bed.resolution = resolution;
  bed.lower = Vec3(-2, -1.5, 0);
  bed.upper = Vec3(2, 1.5, 2.4);
  const double in = 0.001, w = 0.5 * width, h = 0.5 * height;
  const auto wall = [&](const char* name, double y0, double y1, double z0, double z1) {
    const Vec3 low(in, y0 + in, z0 + in), high(0.1 - in, y1 - in, z1 - in);
    bed.primitives.push_back({Primitive::Kind::box, name, 0.5 * (low + high), high - low, 0});
  };
  wall("wall left", w, 1.5, 0, 2.4);
  wall("wall right", -1.5, -w, 0, 2.4);
  if (height < 2.4) {
    wall("sill", -w, w, 0, kWindow.z() - h);
    wall("lintel", -w, w, kWindow.z() + h, 2.4);
  }
  return bed;
}
/// A room of 4 x 4 x 2.4 m with a square pole of this width [m] from floor to ceiling at x = 0, y = 0.
inline DistanceMap pole_room(double width) {
  TestBed bed;
  bed.name = "pole";
  bed.resolution = 0.05;
  bed.lower = Vec3(-2, -2, 0);
  bed.upper = Vec3(2, 2, 2.4);
  bed.primitives.push_back({Primitive::Kind::box, "pole", Vec3(0, 0, 1.2), Vec3(width, width, 2.38), 0});
  return DistanceMap::create(*make_octree(bed).value(), "").value();
}
inline allocation::RotorLoad rotor_load(const vehicle::Vehicle& v, double alpha) {
  return allocation::RotorLoad::create(v, alpha).value();
}
inline Rotors rotors_of(const vehicle::Vehicle& v, double alpha) {
  return Rotors::create(v, alpha, MotionLimits{}.rotor_headroom).value();
}
inline StateCheck make_check(const DistanceMap& map, double alpha_deg, double margin) {
  const auto v = omnimorph();
  const double alpha = to_radians(alpha_deg);
  auto rotors = std::make_shared<const allocation::RotorLoad>(rotor_load(v, alpha));
  return {map, cover_with_spheres(v, alpha), std::move(rotors), 0.05, margin};
}

}  // namespace omniflight::planning
