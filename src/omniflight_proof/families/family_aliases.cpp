#include "family_aliases.hpp"

#include <iterator>

namespace omniflight::proof {
namespace {

struct Merge {
  const char *when, *effect, *as;
};
constexpr Merge kMerges[] = {
    {"always", "thrust_scale", "payload_mass"},
    {"always", "cable_pendulum", "hung_cable"},
    {"always", "cable_chain", "hung_cable"},
    {"no accelerometer", "wind", "mocap_tilt"},
    {"no rotor speeds", "dynamic_inflow", "motor_lag"},
    {"fixed tilt", "tilt_efficiency", "payload_mass"},
    {"T1", "hung_cable", "payload_mass"},
    {"T1", "cable_pendulum", "payload_mass"},
    {"T1", "cable_chain", "payload_mass"},
    {"T1", "constant_pull", "payload_mass"},
    {"T1", "overhead_rope", "payload_mass"},
    {"T1", "ground_effect", "payload_mass"},
    {"T1", "ceiling_effect", "payload_mass"},
};

bool applies(const std::string& when, const Coordinates& c) {
  return when == "always" || (when == "no accelerometer" && !c.imu()) ||
         (when == "no rotor speeds" && !c.speed()) || (when == "fixed tilt" && c.tilt == "fixed") ||
         (when == "T1" && c.manoeuvre == "T1");
}

}  // namespace

std::string family_names(const std::string& effect, const Coordinates& where) {
  for (auto m = std::rbegin(kMerges); m != std::rend(kMerges); ++m)  // the special before the general
    if (effect == m->effect && applies(m->when, where)) return m->as;
  return effect;
}

std::string family_alias_table() {
  std::string out;
  for (const Merge& m : kMerges) out += std::string(m.when) + ": " + m.effect + " = " + m.as + "\n";
  return out;
}

bool stage_is_right(const std::string& effect, const std::string& own, const std::string& said,
                    const Coordinates& where) {
  if (said == own) return true;
  if (own == "actuation" && !where.speed())
    return said == "wrench";  // nothing else shows what the rotors did
  if (effect == "battery_sag") return said == "sensing" || said == "power";
  if (effect == "structural_mode") return said == "sensing" || said == "motion";
  if (effect == "tilt_servo_lag") return said == "wrench" || said == "actuation";
  if (effect == "controller_mismatch") return said == "allocation" || said == "actuation";
  return own == "sensing" && said == "motion";
}

}  // namespace omniflight::proof
