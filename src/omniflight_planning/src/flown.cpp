#include "omniflight_planning/flown.hpp"

#include <cmath>

#include "octree_boxes.hpp"
#include "omniflight_planning/octree_file.hpp"

namespace omniflight::planning {
namespace {

constexpr double kFlownTiltTolerance = to_radians(0.5);  // moves a rim of 0.1 m by less than 1 mm

}  // namespace

Result<FlownClearance> flown_clearance(const std::vector<FlownPose>& path, const vehicle::Vehicle& vehicle,
                                       const std::filesystem::path& map) {
  const auto tree = read_octree(map);
  if (!tree) return Failure(tree.error());
  OctreeBoxes boxes(*tree->tree);
  FlownClearance out;
  out.least = kBoxHorizon;
  VehicleSpheres spheres;
  double alpha = HUGE_VAL;
  for (const FlownPose& flown : path) {
    if (!is_finite(flown.pose)) continue;
    if (!(std::abs(flown.alpha - alpha) <= kFlownTiltTolerance)) {
      alpha = flown.alpha;
      spheres = cover_with_spheres(vehicle, alpha);
    }
    const double clearance = boxes.clearance(flown.pose, spheres);
    if (clearance < out.least) out = {clearance, flown.t, flown.pose.p_WB};
  }
  return out;
}

}  // namespace omniflight::planning
