// The explicit table: an object file nobody names is dropped from a static archive, so nothing registers
// itself.
#include "effects/table.hpp"

#include <algorithm>

namespace omniflight::physics {

const std::vector<const Effect*>& builtin_effects() {
  static const std::vector<const Effect*> table{
      &payload_mass_effect(),
      &com_offset_effect(),
      &inertia_error_effect(),
      &rotor_axis_misalignment_effect(),
      &tilt_offset_effect(),
      &rotor_position_error_effect(),
      &thrust_scale_effect(),
      &rotor_thrust_scale_effect(),
      &reverse_thrust_asymmetry_effect(),
      &thrust_curve_effect(),
      &drag_torque_scale_effect(),
      &rotor_inertia_effect(),
      &tilt_efficiency_effect(),
      &downwash_interference_effect(),
      &rotor_drag_effect(),
      &axial_inflow_effect(),
      &parasitic_drag_effect(),
      &blade_flapping_effect(),
      &wind_effect(),
      &gust_effect(),
      &ground_effect_effect(),
      &ceiling_effect_effect(),
      &wall_effect_effect(),
      &vortex_ring_effect(),
      &dynamic_inflow_effect(),
      &neighbour_downwash_effect(),
      &hung_cable_effect(),
      &cable_pendulum_effect(),
      &cable_chain_effect(),
      &slung_load_effect(),
      &constant_pull_effect(),
      &overhead_rope_effect(),
      &taut_rope_effect(),
      &catenary_effect(),
      &hanging_start_effect(),
      &lateral_stiffness_effect(),
      &cable_drag_effect(),
      &cable_torsion_effect(),
      &attachment_torque_effect(),
      &guide_friction_effect(),
      &motor_lag_effect(),
      &thrust_dead_zone_effect(),
      &command_quantisation_effect(),
      &battery_sag_effect(),
      &actuator_saturation_effect(),
      &tilt_servo_lag_effect(),
      &controller_mismatch_effect(),
      &transport_delay_effect(),
      &accelerometer_error_effect(),
      &gyro_error_effect(),
      &imu_lever_arm_effect(),
      &sensor_filter_effect(),
      &vibration_effect(),
      &structural_mode_effect(),
      &mocap_tilt_effect(),
      &mocap_offset_effect(),
      &clock_offset_effect(),
      &stale_samples_effect(),
      &rotor_speed_sensor_fault_effect(),
      &battery_sensor_fault_effect(),
  };
  return table;
}

const Effect* find_effect(const std::string& id) {
  for (const Effect* effect : builtin_effects())
    if (effect->info().id == id) return effect;
  return nullptr;
}

std::vector<std::string> aliases_of(const EffectInfo& info) {
  std::vector<std::string> out = info.aliases;
  for (const Effect* other : builtin_effects()) {
    const auto& theirs = other->info().aliases;
    if (std::find(theirs.begin(), theirs.end(), info.id) != theirs.end() &&
        std::find(out.begin(), out.end(), other->info().id) == out.end())
      out.push_back(other->info().id);
  }
  return out;
}

}  // namespace omniflight::physics
