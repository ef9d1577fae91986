#include "omniflight_planning/flown.hpp"

#include <algorithm>
#include <cmath>

#include "octree_boxes.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

constexpr double kFlownTiltTolerance = to_radians(0.5);  // moves a rim of 0.1 m by less than 1 mm
/// Beyond the least clearance so far, how much is measured: poses that are no farther away need no look.
constexpr double kLookAhead = 0.05;  // m

}  // namespace

struct FlownCheck::Impl {
  OctreeBoxes boxes;
};

FlownCheck::FlownCheck(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FlownCheck::FlownCheck(FlownCheck&&) noexcept = default;
FlownCheck& FlownCheck::operator=(FlownCheck&&) noexcept = default;
FlownCheck::~FlownCheck() = default;

Result<FlownCheck> FlownCheck::load(const std::filesystem::path& map, const Zones& zones) {
  const auto tree = read_octree(map);
  if (!tree) return Failure(tree.error());
  return FlownCheck(std::make_unique<Impl>(Impl{OctreeBoxes(*tree->tree, zones)}));
}

FlownClearance FlownCheck::clearance(const std::vector<FlownPose>& path, const vehicle::Vehicle& vehicle) {
  FlownClearance out;
  out.least = kBoxHorizon;
  VehicleSpheres spheres;
  double alpha = HUGE_VAL, free = 0.0;  // free: m, at `looked`
  Pose looked;
  for (const FlownPose& flown : path) {
    if (!is_finite(flown.pose)) continue;
    if (!(std::abs(flown.alpha - alpha) <= kFlownTiltTolerance)) {
      alpha = flown.alpha;
      spheres = cover_with_spheres(vehicle, alpha);
    } else if ((flown.pose.p_WB - looked.p_WB).norm() +
                   spheres.bounding_radius * flown.pose.q_WB.angularDistance(looked.q_WB) <
               free - out.least) {
      continue;  // no point of the vehicle has moved far enough to be nearer than the least
    }
    looked = flown.pose;
    free = impl_->boxes.clearance(flown.pose, spheres, out.least + kLookAhead);
    if (free < out.least) out = {free, flown.t, flown.pose.p_WB};
  }
  return out;
}

FlownTether FlownCheck::tether(const std::vector<FlownPose>& path, const Tether& tether) const {
  FlownTether out;
  out.nearest = kBoxHorizon;
  double twist = 0.0, free = 0.0;  // free: m, of the line that was looked at
  Vec3 looked_begin = Vec3::Zero(), looked_end = Vec3::Zero();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const Pose& pose = path[k].pose;
    const Vec3 end = tether.attachment_W(pose.p_WB, pose.q_WB);
    const Vec3 begin = loose_from(tether, end);
    // no point of a straight line moves farther than both its ends
    if (k == 0 ||
        !(std::max((begin - looked_begin).norm(), (end - looked_end).norm()) < free - out.nearest)) {
      looked_begin = begin, looked_end = end;
      free = impl_->boxes.segment_distance(begin, end, out.nearest + kLookAhead);
      out.nearest = std::min(out.nearest, free);
    }
    const Vec3 way = end - tether.anchor_W;
    out.longest = std::max(out.longest, way.norm());
    const Vec3 along = way.stableNormalized();
    const double cosine = tether.cone_axis_B.dot(pose.q_WB.conjugate() * -along);
    out.widest = std::max(out.widest, std::acos(std::clamp(cosine, -1.0, 1.0)));
    if (k == 0) continue;
    const Vec3 turned = log_rotation(path[k - 1].pose.q_WB.conjugate() * pose.q_WB);
    twist += (pose.q_WB * turned).dot(along);
    out.twist = std::max(out.twist, std::abs(twist));
  }
  return out;
}

std::optional<std::string> FlownTether::violation(const Tether& tether) const {
  if (longest > tether.length)
    return text("the tether of %.3f m was pulled to %.3f m", tether.length, longest);
  if (widest > tether.cone)
    return text("the tether left its cone of %.1f deg: %.1f deg", to_degrees(tether.cone),
                to_degrees(widest));
  if (twist > tether.twist)
    return text("the tether was twisted by %.1f deg, %.1f are allowed", to_degrees(twist),
                to_degrees(tether.twist));
  if (nearest <= 0.0) return std::string("the tether touched the map");
  return std::nullopt;
}

Result<FlownClearance> flown_clearance(const std::vector<FlownPose>& path, const vehicle::Vehicle& vehicle,
                                       const std::filesystem::path& map, const Zones& zones) {
  auto check = FlownCheck::load(map, zones);
  if (!check) return Failure(check.error());
  return check->clearance(path, vehicle);
}

}  // namespace omniflight::planning
