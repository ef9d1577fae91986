// Every effect of the library, one accessor each; table.cpp lists them.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

const Effect& payload_mass_effect();
const Effect& com_offset_effect();
const Effect& inertia_error_effect();
const Effect& rotor_axis_misalignment_effect();
const Effect& tilt_offset_effect();
const Effect& rotor_position_error_effect();
const Effect& thrust_scale_effect();
const Effect& rotor_thrust_scale_effect();
const Effect& reverse_thrust_asymmetry_effect();
const Effect& thrust_curve_effect();
const Effect& drag_torque_scale_effect();
const Effect& rotor_inertia_effect();
const Effect& tilt_efficiency_effect();
const Effect& downwash_interference_effect();
const Effect& rotor_drag_effect();
const Effect& axial_inflow_effect();
const Effect& parasitic_drag_effect();
const Effect& blade_flapping_effect();
const Effect& wind_effect();
const Effect& gust_effect();
const Effect& ground_effect_effect();
const Effect& ceiling_effect_effect();
const Effect& wall_effect_effect();
const Effect& vortex_ring_effect();
const Effect& dynamic_inflow_effect();
const Effect& neighbour_downwash_effect();
const Effect& hung_cable_effect();
const Effect& cable_pendulum_effect();
const Effect& cable_chain_effect();
const Effect& slung_load_effect();
const Effect& constant_pull_effect();
const Effect& overhead_rope_effect();
const Effect& taut_rope_effect();
const Effect& catenary_effect();
const Effect& hanging_start_effect();
const Effect& lateral_stiffness_effect();
const Effect& cable_drag_effect();
const Effect& cable_torsion_effect();
const Effect& attachment_torque_effect();
const Effect& guide_friction_effect();
const Effect& motor_lag_effect();
const Effect& thrust_dead_zone_effect();
const Effect& command_quantisation_effect();
const Effect& battery_sag_effect();
const Effect& actuator_saturation_effect();
const Effect& tilt_servo_lag_effect();
const Effect& controller_mismatch_effect();
const Effect& transport_delay_effect();
const Effect& accelerometer_error_effect();
const Effect& gyro_error_effect();
const Effect& imu_lever_arm_effect();
const Effect& sensor_filter_effect();
const Effect& vibration_effect();
const Effect& structural_mode_effect();
const Effect& mocap_tilt_effect();
const Effect& mocap_offset_effect();
const Effect& clock_offset_effect();
const Effect& stale_samples_effect();
const Effect& rotor_speed_sensor_fault_effect();
const Effect& battery_sensor_fault_effect();

}  // namespace omniflight::physics
