// What no flight of the proof can tell apart, declared before any run: the only merging that scoring does.
#pragma once

#include <string>
#include <string_view>

namespace omniflight::proof {

/// The name under which scoring counts an effect on a flight. From the catalogue's own confounding study of
/// this vehicle (cosine of whitened columns above 0.995):
///   every flight: thrust_scale = payload_mass (motion and speeds give their ratio alone), wind = mocap_tilt
///   T1 (one height, level, one tilt): payload_mass = thrust_scale = hung_cable = constant_pull =
///     overhead_rope = tilt_efficiency = ground_effect = ceiling_effect
std::string merged(const std::string& effect, std::string_view flight);

/// The table as text, so that its SHA-256 can stand beside the answers.
std::string alias_table();

}  // namespace omniflight::proof
