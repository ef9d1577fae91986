#include "omniflight_planning/state_check.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {
/// Less room than this beyond the margin counts as none: it bounds the number of steps.
constexpr double kLeastRoom = 2e-4;  // m
/// With this much room beyond the margin the bounding spheres of the parts are accurate enough.
constexpr double kCoarse = 0.08;                 // m
constexpr std::size_t kKnotsBetweenLooks = 256;  // at the clock
}  // namespace

Pose interpolate(const Pose& a, const Pose& b, double s) {
  return {a.p_WB + s * (b.p_WB - a.p_WB), a.q_WB.slerp(s, b.q_WB).normalized()};
}

bool is_finite(const Pose& pose) {
  return pose.p_WB.allFinite() && pose.q_WB.coeffs().allFinite() && std::abs(pose.q_WB.norm() - 1.0) < 1e-6;
}

StateCheck::StateCheck(const DistanceMap& map, VehicleSpheres spheres,
                       std::shared_ptr<const allocation::RotorLoad> rotors, double headroom, double margin)
    : map_(map),
      spheres_(std::move(spheres)),
      rotors_(std::move(rotors)),
      headroom_(headroom),
      margin_(margin) {}

Clearance StateCheck::clearance(const Pose& pose) const {
  Clearance best{map_.max_distance(), pose.p_WB};
  const Mat3 R = pose.q_WB.toRotationMatrix();
  const auto look = [&](const BodySphere& s) {
    const Vec3 p = pose.p_WB + R * s.p_BS;
    return Clearance{map_.distance(p) - s.radius, p};
  };
  for (const SphereGroup& group : spheres_.groups) {
    if (look(group.bound).distance >= best.distance) continue;
    for (const BodySphere& s : group.spheres)
      if (const Clearance c = look(s); c.distance < best.distance) best = c;
  }
  return best;
}

double StateCheck::room(const Pose& pose) const {
  const double enough = margin_ + kCoarse;
  if (const double d = map_.distance(pose.p_WB) - spheres_.bounding_radius; d >= enough) return d - margin_;
  double best = map_.max_distance();
  const Mat3 R = pose.q_WB.toRotationMatrix();
  const auto look = [&](const BodySphere& s) { return map_.distance(pose.p_WB + R * s.p_BS) - s.radius; };
  for (const SphereGroup& group : spheres_.groups) {
    const double coarse = look(group.bound);
    if (coarse >= best) continue;
    if (coarse >= enough) {
      best = coarse;
      continue;
    }
    double fine = map_.max_distance();
    for (const BodySphere& s : group.spheres) fine = std::min(fine, look(s));
    best = std::min(best, fine);
    if (best <= margin_) break;
  }
  return best - margin_;
}

bool StateCheck::valid(const Pose& pose) const {
  return is_finite(pose) && room(pose) > kLeastRoom && hoverable(pose.q_WB);
}

bool StateCheck::motion_valid(const Pose& a, const Pose& b) const {
  if (!valid(a) || !valid(b)) return false;
  const double angle = a.q_WB.angularDistance(b.q_WB);
  const double length = (b.p_WB - a.p_WB).norm() + angle * spheres_.bounding_radius;
  const int attitudes = static_cast<int>(std::ceil(angle / to_radians(2.0)));
  for (int k = 1; k < attitudes; ++k)
    if (!hoverable(interpolate(a, b, static_cast<double>(k) / attitudes).q_WB)) return false;
  double s = 0.0;
  while (s < 1.0) {
    const double free = room(interpolate(a, b, s));
    if (free <= kLeastRoom) return false;
    if (length <= 0.0) return true;
    s += free / length;
  }
  return true;
}

double speed_bound(const TrajectoryKnot& k0, const TrajectoryKnot& k1, double radius) {
  const double h = k1.t - k0.t;
  // Bernstein control points of the derivative of the quintic with these ends: the curve stays in their hull.
  const auto bound = [h](const Vec3& x0, const Vec3& v0, const Vec3& a0, const Vec3& x1, const Vec3& v1,
                         const Vec3& a1) {
    const Vec3 c[6] = {x0,
                       x0 + v0 * (h / 5.0),
                       x0 + v0 * (2.0 * h / 5.0) + a0 * (h * h / 20.0),
                       x1 - v1 * (2.0 * h / 5.0) + a1 * (h * h / 20.0),
                       x1 - v1 * (h / 5.0),
                       x1};
    double most = 0.0;
    for (int i = 0; i < 5; ++i) most = std::max(most, (c[i + 1] - c[i]).norm() * 5.0 / h);
    return most;
  };
  const Reference &r0 = k0.reference, &r1 = k1.reference;
  const double translation = bound(r0.p_WB, r0.v_WB_W, r0.a_WB_W, r1.p_WB, r1.v_WB_W, r1.a_WB_W);
  // The attitude between knots is R0 exp(phi(t)); |body rate| <= |dphi/dt| because the Jacobian never
  // stretches.
  const Vec3 phi = log_rotation(r0.q_WB.conjugate() * r1.q_WB);
  const Mat3 to_phi = right_jacobian_inverse(phi);
  const Vec3 dphi = to_phi * r1.w_WB_B;
  const double rotation = bound(Vec3::Zero(), r0.w_WB_B, r0.dw_WB_B, phi, dphi,
                                to_phi * (r1.dw_WB_B - jacobian_rate_times(phi, dphi)));
  return translation + radius * rotation;
}

CurveCheck StateCheck::curve(const Trajectory& trajectory, const Deadline& deadline) const {
  CurveCheck out;
  out.min_clearance = map_.max_distance();
  const auto& knots = trajectory.knots();
  if (knots.empty()) return out;
  const auto pose_at = [&](double t) {
    const Reference r = trajectory.sample(t);
    return Pose{r.p_WB, r.q_WB};
  };
  const auto note = [&](double t) {
    const Clearance c = clearance(pose_at(t));
    if (c.distance >= out.min_clearance) return;
    out.min_clearance = c.distance;
    out.at = t;
    out.p_W = c.p_W;
  };
  double left = 0.0;  // distance that may still be travelled without looking again
  const auto look = [&](double t) {
    left = room(pose_at(t));
    ++out.witnesses;
    if (left <= 0.1 * kLeastRoom) note(t);
    return left > 0.1 * kLeastRoom;
  };
  if (!look(0.0)) return out;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    if (k % kKnotsBetweenLooks == 0 && deadline.passed()) {
      out.out_of_time = true;
      return out;
    }
    const double speed = speed_bound(knots[k], knots[k + 1], spheres_.bounding_radius);
    double t = knots[k].t;
    while (speed * (knots[k + 1].t - t) >= left) {
      t += left / speed;
      if (!look(t)) return out;
    }
    left -= speed * (knots[k + 1].t - t);
  }
  // The report's least clearance is looked for more accurately than the advance needs.
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (k % kKnotsBetweenLooks == 0 && deadline.passed()) {
      out.out_of_time = true;
      return out;
    }
    if (k % 10 == 0 || k + 1 == knots.size()) note(knots[k].t);
  }
  // The field's bound is not continuous between voxels, so it may fall short of what the advance has proven.
  out.min_clearance = std::max(out.min_clearance, margin_);
  out.free = true;
  return out;
}

}  // namespace omniflight::planning
