#include "omniflight_planning/tether.hpp"

#include <algorithm>
#include <utility>

#include "omniflight_planning/payload.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

constexpr double kHalfPiece = 0.005;       // m, pieces of the segment that are not divided further
constexpr double kShortestSegment = 1e-6;  // m, below which a segment has no direction
constexpr double kShownReserve = 5e-4;     // m, below which messages do not speak of tracking errors

/// Least distance of a piece of the segment: its centre's, less half of its length.
double least(const DistanceMap& map, const Vec3& a, const Vec3& b, double best) {
  const double half = 0.5 * (b - a).norm();
  const Vec3 middle = 0.5 * (a + b);
  const double bound = map.distance(middle) - half;
  if (bound >= best || best <= 0.0) return best;
  if (half <= kHalfPiece) return bound;
  return least(map, middle, b, least(map, a, middle, best));
}

double angle_from_axis(const Tether& tether, const Vec3& direction_W, const Quat& q_WB) {
  return std::acos(std::clamp(tether.cone_axis_B.dot(q_WB.conjugate() * direction_W), -1.0, 1.0));
}

}  // namespace

Vec3 loose_from(const Tether& tether, const Vec3& end) {
  const Vec3 way = end - tether.anchor_W;
  const double distance = way.norm();
  return distance <= kTiedWithin ? end : Vec3(tether.anchor_W + way * (kTiedWithin / distance));
}

double tether_slack(const Tether& tether, double reach, const Vec3& p_WB, const Quat& q_WB) {
  const Vec3 way = tether.anchor_W - tether.attachment_W(p_WB, q_WB);
  const double distance = way.norm(), slack = tether.length - distance;
  if (tether.cone >= kPi) return slack - tether.reserve;
  if (distance < kShortestSegment) return -tether.reserve;
  // a motion by d < distance turns the segment by asin(d / distance) <= pi/2 d / distance at most, and the
  // body by d / reach
  const double left = tether.cone - angle_from_axis(tether, way / distance, q_WB);
  return std::min({slack, distance, left / (0.5 * kPi / distance + 1.0 / reach)}) - tether.reserve;
}

double tether_distance(const Tether& tether, const DistanceMap& map, const Vec3& p_WB, const Quat& q_WB,
                       double enough) {
  const Vec3 end = tether.attachment_W(p_WB, q_WB);
  return least(map, loose_from(tether, end), end, enough);
}

std::optional<TetherConflict> tether_conflict(const Tether& tether, double near, double margin, double reach,
                                              const Vec3& p_WB, const Quat& q_WB) {
  const Vec3 way = tether.anchor_W - tether.attachment_W(p_WB, q_WB);
  const double distance = way.norm();
  const auto blocked = [](std::string words) { return TetherConflict{false, std::move(words)}; };
  if (distance + tether.reserve >= tether.length)
    return TetherConflict{
        true,
        text("the tether of %.3f m is shorter than the way from its anchor to the vehicle, %.3f m%s",
             tether.length, distance,
             tether.reserve >= kShownReserve ? text(" and %.3f m of tracking errors", tether.reserve).c_str()
                                             : "")};
  if (tether.cone < kPi && distance >= kShortestSegment)
    if (const double angle = angle_from_axis(tether, way / distance, q_WB); angle >= tether.cone)
      return blocked(text("the tether leaves the vehicle at %.1f deg from the axis of its cone of %.1f deg",
                          to_degrees(angle), to_degrees(tether.cone)));
  if (near <= margin)
    return blocked(text("the tether comes within %.3f m of the voxels, and %.3f m of clearance are asked for",
                        std::max(0.0, near), margin));
  if (tether_slack(tether, reach, p_WB, q_WB) <= 0.0)
    return blocked(tether.reserve >= kShownReserve
                       ? text("the tether may leave its cone when the vehicle is %.3f m off its reference",
                              tether.reserve)
                       : text("the tether leaves the vehicle at the edge of its cone of %.1f deg",
                              to_degrees(tether.cone)));
  return std::nullopt;
}

TetherUse tether_use(const Tether& tether, const std::vector<TrajectoryKnot>& knots) {
  TetherUse use{.length = tether.length, .mass = tether.mass()};
  double twist = 0.0, before = 0.0;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const Reference& r = knots[k].reference;
    const Vec3 way = tether.attachment_W(r.p_WB, r.q_WB) - tether.anchor_W;
    const double distance = way.norm();
    use.longest = std::max(use.longest, distance);
    const double rate = distance < kShortestSegment ? 0.0 : (r.q_WB * r.w_WB_B).dot(way / distance);
    if (k > 0) twist += 0.5 * (rate + before) * (knots[k].t - knots[k - 1].t);
    before = rate;
    if (std::abs(twist) > use.twist) use.twist = std::abs(twist), use.twist_at = knots[k].t;
  }
  return use;
}

std::optional<std::string> twist_conflict(const Tether& tether, const TetherUse& use) {
  if (!(use.twist > tether.twist * (1.0 + 1e-6))) return std::nullopt;
  return text("the way twists the tether by %.1f deg at %.2f s, %.1f are allowed", to_degrees(use.twist),
              use.twist_at, to_degrees(tether.twist));
}

vehicle::Vehicle carrying(const vehicle::Vehicle& vehicle, const Tether& tether) {
  return carrying(vehicle, Payload{.mass = tether.mass(), .p_B = tether.attachment_B});
}

}  // namespace omniflight::planning
