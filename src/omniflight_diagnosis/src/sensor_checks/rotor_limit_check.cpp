#include "rotor_limit_check.hpp"

#include <algorithm>

#include "../conditioning/rotor_limits.hpp"
#include "../numerics/text.hpp"
#include "findings.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {

void add_rotor_limits(const recording::Recording& r, const vehicle::Vehicle& vehicle, Diagnosis& d) {
  const RotorLimits limits = rotor_limits(r);
  double largest = 0;
  for (const vehicle::Rotor& rotor : vehicle.rotors) largest = std::max(largest, rotor.max_speed());
  if (limits.ceiling && limits.ceiling->to < (1 - kPlateau) * largest &&
      !is_named(d, physics::effect_id::actuator_saturation)) {
    const LimitSpeed& c = *limits.ceiling;
    const auto loss = [&](double speed) { return 1 - speed * speed / (largest * largest); };
    add_sensor(d, physics::effect_id::actuator_saturation, "rotor_speed", "rad/s",
               format("No rotor turns quicker than %.4g rad/s, whatever it is ordered; the vehicle file says "
                      "%.4g rad/s. %.0f %% of the largest thrust are missing.",
                      c.value, largest, 100 * loss(c.value)),
               {{"limit_loss", "l", "1", loss(c.value), loss(c.to), loss(c.from)}}, largest - c.value,
               0.5 * kPlateau * c.value);
    const physics::Effect* effect = physics::find_effect(physics::effect_id::actuator_saturation);
    d.model.push_back({effect, {loss(c.value), effect->info().parameters[1].neutral}});
  }
  if (limits.dead && limits.reads_slower && !is_named(d, physics::effect_id::thrust_dead_zone)) {
    const LimitSpeed& z = *limits.dead;
    add_sensor(d, physics::effect_id::thrust_dead_zone, "rotor_speed", "rad/s",
               format("Rotors stand still where they are ordered to turn slower than %.3g rad/s.", z.value),
               {{"dead_speed", "Omega_min", "rad/s", z.value, z.from, z.to}}, z.value,
               std::max(1.0, 0.5 * (z.to - z.from)));
    d.model.push_back({physics::find_effect(physics::effect_id::thrust_dead_zone), {z.value, 0.0}});
  }
}

}  // namespace omniflight::diagnosis
