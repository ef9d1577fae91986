// Ids of the effects that code outside this package names: checks that report them, and equations that are
// written twice for speed.
//
// Elsewhere an id is never written as text: tests/test_architecture.py finds it. What treats an effect in a
// way of its own asks the effect (EffectInfo, Effect), so that an effect is added in one file.
#pragma once

namespace omniflight::physics::effect_id {

// wrench
inline constexpr const char* payload_mass = "payload_mass";
inline constexpr const char* com_offset = "com_offset";
inline constexpr const char* inertia_error = "inertia_error";
inline constexpr const char* rotor_thrust_scale = "rotor_thrust_scale";
inline constexpr const char* rotor_inertia = "rotor_inertia";
inline constexpr const char* tilt_efficiency = "tilt_efficiency";
inline constexpr const char* rotor_drag = "rotor_drag";
inline constexpr const char* axial_inflow = "axial_inflow";
inline constexpr const char* parasitic_drag = "parasitic_drag";
inline constexpr const char* blade_flapping = "blade_flapping";
inline constexpr const char* wind = "wind";
inline constexpr const char* ground_effect = "ground_effect";
inline constexpr const char* dynamic_inflow = "dynamic_inflow";
inline constexpr const char* neighbour_downwash = "neighbour_downwash";
inline constexpr const char* hung_cable = "hung_cable";
inline constexpr const char* constant_pull = "constant_pull";
inline constexpr const char* overhead_rope = "overhead_rope";
inline constexpr const char* lateral_stiffness = "lateral_stiffness";
inline constexpr const char* attachment_torque = "attachment_torque";

// actuation
inline constexpr const char* motor_lag = "motor_lag";
inline constexpr const char* thrust_dead_zone = "thrust_dead_zone";
inline constexpr const char* command_quantisation = "command_quantisation";
inline constexpr const char* battery_sag = "battery_sag";
inline constexpr const char* actuator_saturation = "actuator_saturation";
inline constexpr const char* tilt_servo_lag = "tilt_servo_lag";
inline constexpr const char* transport_delay = "transport_delay";

// control
inline constexpr const char* controller_mismatch = "controller_mismatch";

// sensing
inline constexpr const char* accelerometer_error = "accelerometer_error";
inline constexpr const char* gyro_error = "gyro_error";
inline constexpr const char* imu_lever_arm = "imu_lever_arm";
inline constexpr const char* mocap_tilt = "mocap_tilt";
inline constexpr const char* mocap_offset = "mocap_offset";
inline constexpr const char* clock_offset = "clock_offset";
inline constexpr const char* sensor_filter = "sensor_filter";
inline constexpr const char* stale_samples = "stale_samples";
inline constexpr const char* vibration = "vibration";
inline constexpr const char* structural_mode = "structural_mode";
inline constexpr const char* rotor_speed_sensor_fault = "rotor_speed_sensor_fault";
inline constexpr const char* battery_sensor_fault = "battery_sensor_fault";

}  // namespace omniflight::physics::effect_id
