#include "offered_effects.hpp"

#include <algorithm>

#include "../conditioning/commanded_drives.hpp"
#include "../conditioning/neighbours.hpp"

namespace omniflight::diagnosis {
namespace {

bool listed(const std::vector<std::string>& list, const std::string& id) {
  return std::find(list.begin(), list.end(), id) != list.end();
}

}  // namespace

std::string why_not_offered(const physics::Effect& effect, std::span<const Flight* const> flights,
                            const vehicle::Vehicle& vehicle, const Options& o) {
  const auto& info = effect.info();
  if (is_of_drives(info)) {
    if (std::any_of(flights.begin(), flights.end(), [](const Flight* f) { return f->commands.empty(); }))
      return "commands and speeds of the rotors tell it, where both are recorded";
  } else if (!effect.can_replay()) {
    return info.stage == physics::Stage::wrench
               ? info.not_asked_for
               : "it is no effect of the wrench: a check of its stage tells it, where there is one";
  }
  if (listed(o.exclude, info.id)) return "excluded by the caller";
  if (!o.only.empty() && !listed(o.only, info.id)) return "not among the effects that the caller asks for";
  for (const Flight* f : flights) {
    if (f->thrust_modelled && !info.hidden_by_modelled_thrust.empty()) return info.hidden_by_modelled_thrust;
    for (const std::string& signal : info.signals) {
      if (signal == "neighbour" && o.neighbours.empty() && !has_neighbour(*f))
        return "no track of a neighbour is recorded or told";
      if (signal == "velocity" && !f->has_position && !f->has("velocity")) return "no velocity is recorded";
      if (signal == "position" && !f->has_position) return "no position is recorded";
      if (signal == "alpha" && vehicle.tilt.kind == vehicle::TiltKind::none) return "no rotor tilts";
      if (signal == "alpha" && !f->has_alpha) return "no tilt angle is recorded";
    }
  }
  return "";
}

std::vector<const physics::Effect*> offered_effects(std::span<const Flight* const> flights,
                                                    const vehicle::Vehicle& vehicle, const Options& o) {
  std::vector<const physics::Effect*> out;
  for (const physics::Effect* effect : physics::builtin_effects())
    if (why_not_offered(*effect, flights, vehicle, o).empty()) out.push_back(effect);
  return out;
}

}  // namespace omniflight::diagnosis
