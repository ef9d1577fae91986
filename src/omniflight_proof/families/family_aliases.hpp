// What no flight of a family can tell apart, declared before any run: the only merging that scoring does.
#pragma once

#include <string>

#include "family.hpp"

namespace omniflight::proof {

/// The name under which scoring counts an effect in such a flight:
///   everywhere: thrust_scale = payload_mass (motion and speeds give their ratio alone); cable_pendulum and
///   cable_chain are laws of hung_cable without accelerometer: wind = mocap_tilt, accelerometer names do not
///   come up without rotor speeds: motor_lag = dynamic_inflow (both are thrust that comes late) fixed tilt:
///   tilt_efficiency = payload_mass T1 (one height): hung_cable, constant_pull, overhead_rope, ground_effect,
///   ceiling_effect = payload_mass
std::string family_names(const std::string& effect, const Coordinates& where);
/// The table as text, so that its SHA-256 can stand beside the answers.
std::string family_alias_table();
/// Stages at which an answer may place an effect: its own, and those where it shows when a signal is missing.
bool stage_is_right(const std::string& effect, const std::string& own, const std::string& said,
                    const Coordinates& where);

}  // namespace omniflight::proof
