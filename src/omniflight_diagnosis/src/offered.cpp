#include "offered.hpp"

#include <algorithm>

#include "neighbours.hpp"

namespace omniflight::diagnosis {

std::vector<const physics::Effect*> offered_effects(std::span<const Flight* const> flights,
                                                    const vehicle::Vehicle& vehicle, const Options& o) {
  std::vector<const physics::Effect*> out;
  const auto listed = [](const std::vector<std::string>& list, const std::string& id) {
    return std::find(list.begin(), list.end(), id) != list.end();
  };
  for (const physics::Effect* effect : physics::builtin_effects()) {
    const auto& info = effect->info();
    if (!effect->can_replay() || listed(o.exclude, info.id)) continue;
    if (!o.only.empty() && !listed(o.only, info.id)) continue;
    bool possible = true;
    for (const Flight* f : flights) {
      // what only scales a thrust whose scale is not known
      if (f->thrust_modelled &&
          (info.id == "thrust_scale" || info.id == "payload_mass" || info.id == "thrust_curve" ||
           info.id == "rotor_thrust_scale" || info.id == "constant_pull" || info.id == "tilt_efficiency"))
        possible = false;
      // without torques it shows only as an accelerometer that sits elsewhere
      if (f->thrust_modelled && info.id == "com_offset") possible = false;
      // and this as one that is mounted askew
      if (f->thrust_modelled && info.id == "rotor_axis_misalignment") possible = false;
      for (const std::string& signal : info.signals) {
        if (signal == "neighbour") possible = possible && (!o.neighbours.empty() || has_neighbour(*f));
        if (signal == "position" || signal == "velocity")
          possible = possible && (f->has_position || f->has("velocity"));
        if (signal == "position") possible = possible && f->has_position;
        if (signal == "alpha")
          possible = possible && f->has_alpha && vehicle.tilt.kind != vehicle::TiltKind::none;
      }
    }
    if (possible) out.push_back(effect);
  }
  return out;
}

}  // namespace omniflight::diagnosis
