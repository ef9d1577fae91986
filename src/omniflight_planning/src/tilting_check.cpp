#include "tilting_check.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr double kTiltsApart = to_radians(1.0);  // of the tilts that poses are looked at with
constexpr double kLeastRoomLeft = 2e-5;          // m beyond the margin that counts as none: bounds the steps
constexpr std::size_t kKnotsBetweenClearances = 10;

/// One pose at its tilt, by the nearest tilt of those kept.
class Look {
 public:
  Look(const vehicle::Vehicle& vehicle, Tilts& tilts) : vehicle_(vehicle), tilts_(tilts) {}

  Status at(const Reference& r) {
    const double near =
        std::clamp(std::round(r.alpha / kTiltsApart) * kTiltsApart, vehicle_.tilt.min, vehicle_.tilt.max);
    pose_ = {r.p_WB, r.q_WB};
    less_ = rim_travel(vehicle_, r.alpha - near);
    const auto found = tilts_.at(near);
    if (!found) return Failure(found.error());
    check_ = &(*found)->check;
    return {};
  }
  double room() const { return check_->room(pose_) - less_; }
  double radius() const { return check_->spheres().bounding_radius + rim_travel(vehicle_, kTiltsApart); }
  double margin() const { return check_->margin(); }
  Clearance clearance() const {
    Clearance out = check_->clearance(pose_);
    out.distance -= less_;
    return out;
  }

 private:
  const vehicle::Vehicle& vehicle_;
  Tilts& tilts_;
  Pose pose_;
  double less_ = 0.0;
  const StateCheck* check_ = nullptr;
};

}  // namespace

double rim_speed(const vehicle::Vehicle& vehicle, const TrajectoryKnot& k0, const TrajectoryKnot& k1) {
  return rim_travel(vehicle, k1.reference.alpha - k0.reference.alpha) / (k1.t - k0.t);
}

Result<CurveCheck> curve_while_tilting(const Trajectory& trajectory, const TiltPiece& piece,
                                       const vehicle::Vehicle& vehicle, Tilts& tilts,
                                       const Deadline& deadline) {
  const auto& knots = trajectory.knots();
  Look look(vehicle, tilts);
  CurveCheck out;
  out.min_clearance = HUGE_VAL;
  const auto note = [&](double t) {
    const Clearance c = look.clearance();
    if (c.distance >= out.min_clearance) return;
    out.min_clearance = c.distance, out.at = t, out.p_W = c.p_W;
  };
  double left = 0.0;  // m, that may still be travelled without looking again
  for (std::size_t k = piece.first; k < piece.last; ++k) {
    if (deadline.passed()) {
      out.out_of_time = true;
      return out;
    }
    double t = knots[k].t;
    if (auto ok = look.at(knots[k].reference); !ok) return Failure(ok.error());
    if ((k - piece.first) % kKnotsBetweenClearances == 0) note(t);
    const double speed =
        speed_bound(knots[k], knots[k + 1], look.radius()) + rim_speed(vehicle, knots[k], knots[k + 1]);
    while (left <= 0.0 || speed * (knots[k + 1].t - t) >= left) {
      if (left > 0.0) t += left / speed;
      if (auto ok = look.at(trajectory.sample(t)); !ok) return Failure(ok.error());
      left = look.room();
      ++out.witnesses;
      if (left <= kLeastRoomLeft) {
        note(t);
        return out;
      }
    }
    left -= speed * (knots[k + 1].t - t);
  }
  out.free = true;
  // the field's bound is not continuous between voxels: it may fall short of what the advance has proven
  out.min_clearance = std::max(out.min_clearance, look.margin());
  return out;
}

}  // namespace omniflight::planning
