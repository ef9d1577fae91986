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

Result<TiltRange> Tilts::range(double from, double to) {
  TiltRange out;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to_degrees(to - from)) - 1e-9)));
  for (int k = 0; k <= steps; ++k) {
    if (deadline_.passed()) return out_of_time(deadline_, "preparing a move of the tilt");
    out.tilts.push_back(k == steps ? to : from + (to - from) * k / steps);
    const auto here = at(out.tilts.back());
    if (!here) return Failure(here.error());
    out.rotors.push_back((*here)->rotors);
  }
  return out;
}

Result<const AtTilt*> Tilts::between(double from, double to, const std::string& where) {
  constexpr double kDiscs = to_radians(4.0);  // between the discs that stand for all tilts
  const std::pair key(from, to);
  if (const auto known = known_between_.find(key); known != known_between_.end()) return &known->second;
  const auto all = range(from, to);
  if (!all) return Failure(all.error());
  std::vector<std::shared_ptr<const allocation::RotorLoad>> loads;
  for (std::size_t k = 0; k < all->tilts.size(); ++k) {
    loads.emplace_back(all->rotors[k], &all->rotors[k]->load());
    if (loads.back()->rank() < 6)
      return bad_input(text("tilt_in_flight: at alpha %.1f deg, on the way from %.1f to %.1f deg, the rotors "
                            "do not give forces and torques in every direction",
                            to_degrees(all->tilts[k]), to_degrees(from), to_degrees(to)),
                       where, "Move the tilt at rest, or between other angles");
  }
  const int discs = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / kDiscs)));
  VehicleSpheres spheres = cover_with_spheres(vehicle_, from);
  for (int k = 1; k <= discs; ++k) {
    VehicleSpheres more = cover_with_spheres(vehicle_, from + (to - from) * k / discs);
    for (SphereGroup& group : more.groups)
      if (group.part.kind == vehicle::CollisionShape::Kind::cylinder && group.part.size.y() == 0.0)
        spheres.groups.push_back(std::move(group));
    spheres.bounding_radius = std::max(spheres.bounding_radius, more.bounding_radius);
  }
  const double apart = rim_travel(vehicle_, 0.5 * (to - from) / discs);
  spheres.bounding_radius += apart;
  const AtTilt& first = known_.at(from);
  AtTilt made{first.rotors,
              first.check.with_margin(first.check.margin() + apart).with_tilts(spheres, std::move(loads)),
              {}};
  return &known_between_.emplace(key, std::move(made)).first->second;
}

Result<const AtTilt*> Tilts::towards(std::size_t i, double from) {
  while (i + 1 < mission_.waypoints.size() && !mission_.waypoints[i].stop) ++i;
  const Waypoint& stop = mission_.waypoints[i];
  if (!stop.tilt_in_flight || !stop.alpha || *stop.alpha == from) return at(from);
  if (auto ok = in_range(*stop.alpha, stop.where); !ok) return Failure(ok.error());
  return between(from, *stop.alpha, stop.where);
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
