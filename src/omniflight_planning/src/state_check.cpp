#include "omniflight_planning/state_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "convex_scene.hpp"
#include "pose_kernel.hpp"
#include "solid.hpp"
#include "triangle_tree.hpp"

namespace omniflight::planning {
namespace {
/// With this much room beyond the margin the bounding spheres of the parts are accurate enough.
constexpr double kCoarse = 0.08;  // m
/// With less room than this by its spheres, a part is measured itself: within this reach beyond the margin.
constexpr double kAmbiguous = 0.01;   // m
constexpr double kExactReach = 0.04;  // m
constexpr double kExactWithin =
    0.2;  // m, clearances below are those of the parts, larger ones of the spheres
constexpr std::size_t kKnotsBetweenLooks = 256;  // at the clock
/// Of a motion, where the slope of the load does not tell of those in between.
constexpr double kAttitudesApart = to_radians(2.0);

std::shared_ptr<const PackedVehicle> packed_for(const DistanceMap& map, const VehicleSpheres& spheres) {
  const auto& size = map.size();
  return std::make_shared<const PackedVehicle>(
      packed(spheres, map.resolution(), std::max({size[0], size[1], size[2]})));
}
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
      packed_(packed_for(map_, spheres_)),
      rotors_(std::move(rotors)),
      headroom_(headroom),
      margin_(margin) {}

StateCheck StateCheck::with_margin(double margin) const {
  StateCheck out = *this;
  out.margin_ = margin;
  return out;
}

StateCheck StateCheck::with_tether(std::optional<Tether> tether) const {
  StateCheck out = *this;
  out.tether_ = std::move(tether);
  // speeds of vehicle points are bounded by this radius, and the attachment is one of them
  if (out.tether_) out.spheres_.bounding_radius = out.tether_->reach(spheres_.bounding_radius);
  return out;
}

StateCheck StateCheck::with_tilts(VehicleSpheres spheres,
                                  std::vector<std::shared_ptr<const allocation::RotorLoad>> rotors) const {
  StateCheck out = *this;
  out.spheres_ = std::move(spheres);
  out.packed_ = packed_for(map_, out.spheres_);
  if (out.tether_) out.spheres_.bounding_radius = out.tether_->reach(out.spheres_.bounding_radius);
  out.other_tilts_ = std::move(rotors);
  return out;
}

bool StateCheck::hoverable(const Quat& q_WB) const {
  const auto holds = [&](const auto& rotors) { return rotors->hover_load(q_WB) <= 1.0 - headroom_; };
  return !rotors_ || holds(rotors_) || std::any_of(other_tilts_.begin(), other_tilts_.end(), holds);
}

bool StateCheck::hoverable_between(const Quat& a, const Quat& b, double angle) const {
  if (!rotors_ || angle <= 0.0) return true;
  const Quat mid(Eigen::Vector4d(a.coeffs() + (a.dot(b) < 0.0 ? -1.0 : 1.0) * b.coeffs()).normalized());
  bool here = false, between = false;
  const auto ask = [&](const allocation::RotorLoad& rotors) {
    const double left = 1.0 - headroom_ - rotors.hover_load(mid);
    here |= left >= 0.0;
    between |= left >= 0.5 * angle * rotors.hover_slope();
  };
  ask(*rotors_);
  for (const auto& rotors : other_tilts_) ask(*rotors);
  if (!here || between) return here;
  if (angle <= kAttitudesApart) return true;
  return hoverable_between(a, mid, 0.5 * angle) && hoverable_between(mid, b, 0.5 * angle);
}

StateCheck StateCheck::among(BodySpace space) const {
  StateCheck out = *this;
  out.space_ = std::move(space);
  return out;
}

std::optional<TetherConflict> StateCheck::tether_conflict(const Pose& pose) const {
  if (!tether_) return {};
  const double near = tether_distance(*tether_, map_, pose.p_WB, pose.q_WB, map_.max_distance());
  return planning::tether_conflict(*tether_, near, margin_, spheres_.bounding_radius, pose.p_WB, pose.q_WB);
}

double StateCheck::room(const Pose& pose, double enough) const {
  if (space_ && space_->looks) space_->looks->fetch_add(1, std::memory_order_relaxed);
  if (!in_space(pose)) return -1.0;
  const double vehicle = room_of_vehicle(pose, enough);
  if (!tether_ || vehicle <= 0.0) return vehicle;
  const double slack =
      std::min(vehicle, tether_slack(*tether_, spheres_.bounding_radius, pose.p_WB, pose.q_WB));
  if (slack <= 0.0) return slack;
  return tether_distance(*tether_, map_, pose.p_WB, pose.q_WB, margin_ + slack) - margin_;
}

double StateCheck::exact(const SphereGroup& group, const Vec3& p_WB, const Mat3& R_WB, double low,
                         double enough) const {
  if (space_) return exact_triangles(group, p_WB, R_WB, low, enough);
  const Solid solid(group.part, p_WB, R_WB);
  const Vec3 c = solid.center();
  const auto at = map_.voxel_of(c);
  if (!map_.contains(c) || map_.occupied(at[0], at[1], at[2])) return 0.0;
  const Vec3 reach(solid.reach(Vec3::UnitX()), solid.reach(Vec3::UnitY()), solid.reach(Vec3::UnitZ()));
  const double half = 0.5 * map_.resolution();
  double best =
      std::min({enough, (c - reach - map_.lower()).minCoeff(), (map_.upper() - c - reach).minCoeff()});
  const Vec3 window = reach + Vec3::Constant(best);
  map_.for_surface(c - window, c + window, [&](const Vec3& cube) {
    const double near = ((cube - c).cwiseAbs().array() - half).max(0.0).matrix().norm() - group.bound.radius;
    if (near < best && best > low) best = std::min(best, solid.distance_to_cube(cube, half, best));
  });
  return std::max(0.0, best);
}

double StateCheck::exact_triangles(const SphereGroup& group, const Vec3& p_WB, const Mat3& R_WB, double low,
                                   double enough) const {
  double best = enough;
  for (std::size_t i = 0; i < group.triangles.size() && best > low; ++i) {
    const BodySphere& s = group.spheres[i];
    const Vec3 center = p_WB + R_WB * s.p_BS;
    if (!map_.contains(center)) return 0.0;
    if (map_.coarse_distance(center) - s.radius >= best || map_.distance(center) - s.radius >= best) continue;
    const auto& t = group.triangles[i];
    best =
        space_->obstacles->distance({p_WB + R_WB * t[0], p_WB + R_WB * t[1], p_WB + R_WB * t[2]}, low, best);
  }
  return std::max(0.0, best);
}

Clearance StateCheck::clearance(const Pose& pose) const {
  return nearest(pose, {map_.max_distance(), pose.p_WB});
}

Clearance StateCheck::nearest(const Pose& pose, Clearance best) const {
  const Mat3 R = pose.q_WB.toRotationMatrix();
  for (const SphereGroup& group : spheres_.groups) {
    if (map_.distance(pose.p_WB + R * group.bound.p_BS) - group.bound.radius >= best.distance) continue;
    Clearance near = best;
    double reached = map_.max_distance();  // some point of the part is no farther away
    for (const BodySphere& s : group.spheres) {
      const Vec3 p = pose.p_WB + R * s.p_BS;
      if (map_.coarse_distance(p) - s.radius >= near.distance) continue;
      const DistanceMap::Bounds d = map_.distance_bounds(p);
      reached = std::min(reached, d.upper + (space_ ? std::sqrt(3.0) * map_.resolution() : 0.0));
      if (d.lower - s.radius < near.distance) near = {d.lower - s.radius, p};
    }
    if (near.distance >= best.distance) continue;
    if (reached > 0.0 && near.distance < kExactWithin)
      if (const double part = exact(group, pose.p_WB, R, 0.0, std::min(reached, best.distance)); part > 0.0)
        near.distance = std::max(near.distance, part);
    if (near.distance < best.distance) best = near;
  }
  return best;
}

float StateCheck::voxels(double length) const { return static_cast<float>(length / map_.resolution()); }

GridPose StateCheck::in_grid(const Pose& pose) const {
  const Vec3 p = (pose.p_WB - map_.lower()) / map_.resolution() + Vec3::Ones();
  const auto& q = pose.q_WB;
  return {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

double StateCheck::room_of_vehicle(const Pose& pose, double enough) const {
  if (space_) return room_of_body(pose, enough);
  if (!is_finite(pose)) return -1.0;
  const double most = std::min(map_.max_distance(), margin_ + enough);
  const float told = room_in_blocks(map_.blocks(), *packed_, in_grid(pose), voxels(margin_), voxels(most));
  return static_cast<double>(told) * map_.resolution() - margin_;
}

double StateCheck::room_of_body(const Pose& pose, double enough) const {
  const double accurate = margin_ + kCoarse;
  double best = std::min(map_.max_distance(), margin_ + enough);
  if (const double d = map_.coarse_distance(pose.p_WB) - spheres_.bounding_radius;
      d >= std::min(best, accurate))
    return d - margin_;
  const Mat3 R = pose.q_WB.toRotationMatrix();
  struct Ambiguous {
    const SphereGroup* group;
    double by_spheres;  // m
  };
  // the voxels stand out of the triangles that they hold, so that what touches one is not hit for certain
  const double stands_out = std::sqrt(3.0) * map_.resolution();
  std::array<Ambiguous, 64> ambiguous;  // what does not fit in counts by its spheres
  std::size_t count = 0;
  for (const SphereGroup& group : spheres_.groups) {
    const Vec3 center = pose.p_WB + R * group.bound.p_BS;
    double coarse = map_.coarse_distance(center) - group.bound.radius;
    if (coarse < std::min(best, accurate)) coarse = map_.distance(center) - group.bound.radius;
    if (coarse >= std::min(best, accurate)) {
      best = std::min(best, coarse);
      continue;
    }
    double fine = map_.max_distance();
    for (const BodySphere& s : group.spheres) {
      const Vec3 p = pose.p_WB + R * s.p_BS;
      if (const double quick = map_.coarse_distance(p) - s.radius;
          quick >= std::min(best, margin_ + kExactReach)) {
        fine = std::min(fine, quick);
        continue;
      }
      const DistanceMap::Bounds d = map_.distance_bounds(p);
      if (d.upper + stands_out < margin_)
        return d.upper + stands_out - margin_;  // a point of the part: certainly hit
      fine = std::min(fine, d.lower - s.radius);
    }
    if (fine < std::min(best, margin_ + kAmbiguous) && count < ambiguous.size())
      ambiguous[count++] = {&group, fine};
    else
      best = std::min(best, fine);
  }
  const double certain = margin_ + kLeastRoom;  // no more counts as hit
  // neither certainly free nor certainly hit: the spheres stick out of the parts, so ask the parts, those
  // first that are likely to be hit
  std::sort(ambiguous.begin(), ambiguous.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Ambiguous& a, const Ambiguous& b) { return a.by_spheres < b.by_spheres; });
  for (std::size_t i = 0; i < count && best > certain; ++i) {
    const double enough_of_part = std::min(best, margin_ + kExactReach);
    best = std::min(best, std::max(ambiguous[i].by_spheres, exact_triangles(*ambiguous[i].group, pose.p_WB, R,
                                                                            certain, enough_of_part)));
  }
  return best - margin_;
}

bool StateCheck::in_space(const Pose& pose) const {
  return !space_ ||
         ((pose.p_WB - space_->lower).minCoeff() >= 0.0 && (space_->upper - pose.p_WB).minCoeff() >= 0.0);
}

bool StateCheck::clear(const Pose& pose) const {
  if (!is_finite(pose)) return false;
  if (space_ || tether_) return room(pose, 2.0 * kLeastRoom) > kLeastRoom;
  const float least = voxels(margin_ + kLeastRoom);
  return room_in_blocks(map_.blocks(), *packed_, in_grid(pose), least, voxels(margin_ + 1.5 * kLeastRoom)) >
         least;
}

bool StateCheck::valid(const Pose& pose) const {
  if (space_ && space_->parts) {
    SeparationMemory memory;
    if (space_->looks) space_->looks->fetch_add(1, std::memory_order_relaxed);
    return is_finite(pose) && in_space(pose) && space_->parts->free(pose, kLeastRoom, memory);
  }
  return clear(pose) && hoverable(pose.q_WB);
}

bool StateCheck::motion_valid(const Pose& a, const Pose& b) const {
  if (!is_finite(a) || !is_finite(b) || !hoverable(a.q_WB) || !hoverable(b.q_WB)) return false;
  if (space_ && space_->parts) {
    SeparationMemory memory;
    const bool free = in_space(a) && in_space(b) && space_->parts->free(a, kLeastRoom, memory) &&
                      space_->parts->motion_free(a, b, kLeastRoom, memory);
    if (space_->looks) space_->looks->fetch_add(memory.looks, std::memory_order_relaxed);
    return free;
  }
  // most motions that are not free are told by a few poses
  if (!clear(b)) return false;
  const double angle = a.q_WB.angularDistance(b.q_WB);
  if (!space_ && !tether_)
    return hoverable_between(a.q_WB, b.q_WB, angle) &&
           motion_in_blocks(map_.blocks(), *packed_, in_grid(a), in_grid(b), voxels(margin_),
                            voxels(kLeastRoom));
  const double length = (b.p_WB - a.p_WB).norm() + angle * spheres_.bounding_radius;
  if (length > kCoarse)
    for (const double at : {0.5, 0.25, 0.75})
      if (!clear(interpolate(a, b, at))) return false;
  if (!hoverable_between(a.q_WB, b.q_WB, angle)) return false;
  double s = 0.0;
  while (s < 1.0) {
    const double free = room(interpolate(a, b, s), (1.0 - s) * length + 2.0 * kLeastRoom);
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
  CurveCheck out = advance_along(trajectory, deadline);
  if (!out.free) return out;
  // The report's least clearance is looked for more accurately than the advance needs.
  const auto& knots = trajectory.knots();
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (k % kKnotsBetweenLooks == 0 && deadline.passed()) {
      out.free = false;
      out.out_of_time = true;
      return out;
    }
    if (k % 10 != 0 && k + 1 != knots.size()) continue;
    const Reference& r = knots[k].reference;
    const Clearance c = nearest({r.p_WB, r.q_WB}, {out.min_clearance, out.p_W});
    if (c.distance < out.min_clearance) {
      out.min_clearance = c.distance;
      out.at = knots[k].t;
      out.p_W = c.p_W;
    }
  }
  // The field's bound is not continuous between voxels, so it may fall short of what the advance has proven.
  out.min_clearance = std::max(out.min_clearance, margin_);
  return out;
}

CurveCheck StateCheck::advance_along(const Trajectory& trajectory, const Deadline& deadline) const {
  CurveCheck out;
  out.min_clearance = map_.max_distance();
  const auto& knots = trajectory.knots();
  if (knots.empty()) return out;
  const auto pose_at = [&](double t) {
    const Reference r = trajectory.sample(t);
    return Pose{r.p_WB, r.q_WB};
  };
  const auto note = [&](double t) {
    const Clearance c = nearest(pose_at(t), {out.min_clearance, out.p_W});
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
  out.free = true;
  return out;
}

}  // namespace omniflight::planning
