#include <cmath>

#include "omniflight_planning/flatness.hpp"
#include "omniflight_planning/plan.hpp"
#include "text.hpp"

namespace omniflight::planning {

namespace {

/// Largest share of the rotors' range that the mission's attitudes and an acceleration in any direction of
/// the world take at one tilt; infinite where the vehicle leans into its motion and a waypoint asks for
/// another attitude. No more is looked at once it reaches `enough`.
double worst_load(const Mission& mission, const allocation::RotorLoad& rotors,
                  const std::optional<FlatVehicle>& flat, double enough) {
  double worst = 0.0;
  for (std::size_t k = 0; k < mission.waypoints.size() && worst < enough; ++k) {
    const Quat& q0 = mission.waypoints[k == 0 ? 0 : k - 1].pose.q_WB;
    if (flat && !flat->heading(mission.waypoints[k].pose.q_WB)) return HUGE_VAL;
    const Quat& q1 = mission.waypoints[k].pose.q_WB;
    const int parts = q0.coeffs() == q1.coeffs() ? 0 : 4;
    for (int part = 0; part <= parts; ++part) {
      Reference r;
      r.q_WB = q0.slerp(0.25 * part, q1);
      for (int axis = 0; axis < 6; ++axis) {
        r.a_WB_W.setZero();
        r.a_WB_W[axis % 3] = (axis < 3 ? 1.0 : -1.0) * mission.limits.acceleration;
        if (!flat) {
          worst = std::max(worst, rotors.motion_load(r));
          continue;
        }
        FlatMotion motion;
        motion.fill(Eigen::Vector4d::Zero());
        motion[0][3] = flat->heading(r.q_WB, kPi).value_or(0.0);
        motion[2].head<3>() = r.a_WB_W;
        worst = std::max(worst, rotors.motion_load(flat_reference(motion, *flat)));
      }
    }
  }
  return worst;
}

struct Best {
  double alpha = 0.0, load = HUGE_VAL;
};

}  // namespace

Result<double> search_alpha(const Mission& mission, const vehicle::Vehicle& vehicle,
                            const Deadline& deadline) {
  Best free{vehicle.tilt.min}, leaning{vehicle.tilt.min};
  const double allowed = 1.0 - mission.limits.rotor_headroom;
  const int steps = static_cast<int>(std::floor(to_degrees(vehicle.tilt.max - vehicle.tilt.min) + 1e-9));
  for (int i = 0; i <= steps; ++i) {
    if (deadline.passed()) return out_of_time(deadline, "searching alpha");
    const double alpha = vehicle.tilt.min + to_radians(i);
    const auto rotors = allocation::RotorLoad::create(vehicle, alpha);
    if (!rotors) return Failure(rotors.error());
    std::optional<FlatVehicle> flat;
    if (rotors->rank() < 6) {
      const auto found = flat_vehicle(vehicle, alpha);
      if (!found) return Failure(found.error());
      flat = *found;
    }
    Best& best = flat ? leaning : free;
    if (const double load = worst_load(mission, *rotors, flat, best.load); load < best.load - 1e-9)
      best = {alpha, load};
  }
  // a vehicle that can command its attitude does so
  if (free.load <= allowed) return free.alpha;
  if (leaning.load <= allowed) return leaning.alpha;
  const Best& best = free.load <= leaning.load ? free : leaning;
  return bad_input(
      text("goal_unhoverable: no alpha between %.0f and %.0f deg lets '%s' hold the mission's attitudes; "
           "the best, %.0f deg, needs %.0f %% of the rotors' range and %.0f %% are allowed",
           to_degrees(vehicle.tilt.min), to_degrees(vehicle.tilt.max), vehicle.name.c_str(),
           to_degrees(best.alpha), 100.0 * best.load, 100.0 * allowed),
      mission.file + ": waypoints", "Tilt less, lower limits.acceleration_mps2 or rotor_headroom");
}

}  // namespace omniflight::planning
