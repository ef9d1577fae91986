#include "tilts.hpp"

#include <algorithm>

#include "text.hpp"
#include "tilt.hpp"

namespace omniflight::planning {

LoadedVehicle with_loads(const Mission& mission, const vehicle::Vehicle& vehicle) {
  LoadedVehicle out;
  out.without_tether = mission.payload ? carrying(vehicle, *mission.payload) : vehicle;
  out.with_tether = mission.tether ? carrying(out.without_tether, *mission.tether) : out.without_tether;
  return out;
}

double margin_of(const Tube& tube, const VehicleSpheres& spheres, const std::optional<Tether>& tether) {
  return tube.margin(tether ? tether->reach(spheres.bounding_radius) : spheres.bounding_radius);
}

Result<const AtTilt*> Tilts::at(double alpha) {
  if (const auto known = known_.find(alpha); known != known_.end()) return &known->second;
  auto made = Rotors::create(vehicle_, alpha, mission_.limits.rotor_headroom);
  if (!made) return Failure(made.error());
  auto rotors = std::make_shared<const Rotors>(std::move(*made));
  const std::shared_ptr<const allocation::RotorLoad> load(rotors, &rotors->load());
  const VehicleSpheres spheres = cover_with_spheres(vehicle_, alpha);
  const double margin = margin_of(tube_, spheres, mission_.tether);
  const StateCheck alone(map_, spheres, load, mission_.limits.rotor_headroom, mission_.clearance + margin);
  std::optional<Tether> tether = mission_.tether;
  if (tether) tether->reserve = margin;
  StateCheck check = tether ? alone.with_tether(tether) : alone;
  std::optional<FlatVehicle> flat;
  if (load->rank() < 6) {
    auto found = flat_vehicle(vehicle_, alpha);
    if (!found) return Failure(found.error());
    flat = *found;
  }
  return &known_.emplace(alpha, AtTilt{std::move(rotors), std::move(check), flat}).first->second;
}

Status Tilts::in_range(double alpha, const std::string& where) const {
  if (alpha >= vehicle_.tilt.min - 1e-9 && alpha <= vehicle_.tilt.max + 1e-9) return {};
  return bad_input(
      text("alpha_out_of_range: %.2f deg is outside the range of '%s', [%.1f, %.1f] deg", to_degrees(alpha),
           vehicle_.name.c_str(), to_degrees(vehicle_.tilt.min), to_degrees(vehicle_.tilt.max)),
      where + ": alpha_deg", "Choose an angle within the range");
}

Result<std::vector<TrajectoryKnot>> Tilts::move(double from, const Waypoint& to) {
  const double change = *to.alpha - from;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to_degrees(change)))));
  for (int k = 0; k <= steps; ++k) {
    if (deadline_.passed()) return out_of_time(deadline_, "checking a move of the tilt");
    const double alpha = from + change * k / steps;
    const auto here = at(alpha);
    if (!here) return Failure(here.error());
    const StateCheck& check = (*here)->check;
    if (check.with_margin(check.margin() + rim_travel(vehicle_, change / steps)).valid(to.pose)) continue;
    const bool hovers = check.hoverable(to.pose.q_WB);
    return fail(ErrorCode::bad_input,
                text("tilt_blocked: %s: at alpha %.1f deg, on the way from %.1f to %.1f deg, %s",
                     to.name.c_str(), to_degrees(alpha), to_degrees(from), to_degrees(*to.alpha),
                     hovers ? "the vehicle does not keep its clearance"
                            : "the rotors cannot hold the attitude with the headroom asked for"),
                to.where, "Move the tilt at another waypoint, or less");
  }
  return move_tilt(to.pose, from, *to.alpha, vehicle_.tilt.rate);
}

}  // namespace omniflight::planning
