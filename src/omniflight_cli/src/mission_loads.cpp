#include "mission_loads.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::cli {
namespace {

namespace load_id = physics::effect_id;

/// Appends an effect; refuses values outside the bounds of its parameters.
Status add_load(std::vector<physics::ActiveEffect>& loads, const char* id, std::vector<double> theta,
                const std::string& where) {
  const physics::Effect* effect = physics::find_effect(id);
  const auto& parameters = effect->info().parameters;
  for (std::size_t k = 0; k < theta.size(); ++k)
    if (!(theta[k] >= parameters[k].lower && theta[k] <= parameters[k].upper))
      return bad_input(
          fmt::format("cannot be flown in the simulator: it is {} with {} = {:.4g} {}, which reaches from "
                      "{:g} to {:g}",
                      id, parameters[k].name, theta[k], parameters[k].unit, parameters[k].lower,
                      parameters[k].upper),
          where, "Make the load lighter or put it nearer to the body origin");
  loads.push_back({effect, std::move(theta)});
  return {};
}

Status add_payload(std::vector<physics::ActiveEffect>& loads, const planning::Payload& payload,
                   const vehicle::Vehicle& vehicle, const std::string& where) {
  if (payload.mass <= 0.0) return {};
  if (auto ok = add_load(loads, load_id::payload_mass, {payload.mass}, where); !ok) return ok;
  if (payload.p_B.isZero()) return {};
  const Vec3 shift = payload.mass / vehicle.mass * payload.p_B;
  if (auto ok = add_load(loads, load_id::com_offset, {shift.x(), shift.y(), shift.z()}, where); !ok)
    return ok;
  const Vec3 square = payload.p_B.cwiseAbs2();
  const Vec3 inertia = payload.mass * (Vec3::Constant(square.sum()) - square);
  return add_load(loads, load_id::inertia_error, {inertia.x(), inertia.y(), inertia.z()}, where);
}

Status add_tether(std::vector<physics::ActiveEffect>& loads, const planning::Tether& tether,
                  const std::vector<TrajectoryKnot>& knots, const std::string& where) {
  if (tether.linear_mass <= 0.0) return {};
  double lowest = HUGE_VAL, highest = -HUGE_VAL;  // m, of the attachment
  for (const TrajectoryKnot& knot : knots) {
    const double z = tether.attachment_W(knot.reference.p_WB, knot.reference.q_WB).z();
    lowest = std::min(lowest, z), highest = std::max(highest, z);
  }
  const double anchor = tether.anchor_W.z();
  // The torque's carried length grows with height from `empty` on, `share` of a metre a metre.
  double empty = anchor, share = 1.0;
  Status ok;
  if (lowest >= anchor) {
    ok = add_load(loads, load_id::hung_cable, {tether.linear_mass, anchor, tether.length}, where);
  } else if (highest <= anchor) {
    empty = anchor - tether.length, share = 0.5;
    ok = add_load(loads, load_id::overhead_rope, {tether.linear_mass, anchor, tether.length}, where);
  } else {
    return bad_input(fmt::format("cannot be flown in the simulator: its attachment passes the height of the "
                                 "anchor ({:.3f} m), it is at {:.3f} to {:.3f} m",
                                 anchor, lowest, highest),
                     where + ": tether.anchor", "Put the anchor below or above all of the way");
  }
  if (!ok || tether.attachment_B.isZero()) return ok;
  const Vec3 lever = share * tether.linear_mass * tether.attachment_B;
  return add_load(loads, load_id::attachment_torque, {lever.x(), lever.y(), lever.z(), empty}, where);
}

}  // namespace

Result<std::vector<physics::ActiveEffect>> effects_of_loads(const planning::Mission& mission,
                                                            const vehicle::Vehicle& vehicle,
                                                            const std::vector<TrajectoryKnot>& knots) {
  std::vector<physics::ActiveEffect> loads;
  if (mission.payload)
    if (auto ok = add_payload(loads, *mission.payload, vehicle, mission.file + ": payload"); !ok)
      return Failure(ok.error());
  if (mission.tether)
    if (auto ok = add_tether(loads, *mission.tether, knots, mission.file + ": tether"); !ok)
      return Failure(ok.error());
  return loads;
}

}  // namespace omniflight::cli
