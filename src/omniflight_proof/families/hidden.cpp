#include "hidden.hpp"

namespace omniflight::proof {

const std::vector<Hidden>& hidden_effects() {
  static const std::vector<Hidden> all = [] {
    std::vector<Hidden> out;
    hide_rigid_body(out);
    hide_propellers(out);
    hide_actuation(out);
    hide_air(out);
    hide_boundaries(out);
    hide_cables(out);
    hide_loads(out);
    hide_springs(out);
    hide_inertial(out);
    hide_sensing(out);
    hide_unknown(out);
    return out;
  }();
  return all;
}

const std::vector<std::string>& catalogue() {
  static const std::vector<std::string> ids{"payload_mass",
                                            "com_offset",
                                            "inertia_error",
                                            "rotor_axis_misalignment",
                                            "tilt_offset",
                                            "rotor_position_error",
                                            "thrust_scale",
                                            "rotor_thrust_scale",
                                            "reverse_thrust_asymmetry",
                                            "thrust_curve",
                                            "drag_torque_scale",
                                            "motor_lag",
                                            "thrust_dead_zone",
                                            "transport_delay",
                                            "command_quantisation",
                                            "battery_sag",
                                            "actuator_saturation",
                                            "rotor_inertia",
                                            "tilt_servo_lag",
                                            "tilt_efficiency",
                                            "downwash_interference",
                                            "rotor_drag",
                                            "axial_inflow",
                                            "parasitic_drag",
                                            "blade_flapping",
                                            "wind",
                                            "gust",
                                            "ground_effect",
                                            "ceiling_effect",
                                            "wall_effect",
                                            "vortex_ring",
                                            "dynamic_inflow",
                                            "neighbour_downwash",
                                            "hung_cable",
                                            "constant_pull",
                                            "overhead_rope",
                                            "taut_rope",
                                            "catenary",
                                            "lateral_stiffness",
                                            "slung_load",
                                            "cable_drag",
                                            "cable_torsion",
                                            "attachment_torque",
                                            "guide_friction",
                                            "hanging_start",
                                            "accelerometer_error",
                                            "gyro_error",
                                            "imu_lever_arm",
                                            "mocap_tilt",
                                            "mocap_offset",
                                            "clock_offset",
                                            "sensor_filter",
                                            "vibration",
                                            "structural_mode",
                                            "rotor_speed_sensor_fault",
                                            "battery_sensor_fault",
                                            "controller_mismatch",
                                            "stale_samples"};
  return ids;
}

double hover_speed(const FamilyFlight& f) {
  const vehicle::Rotor& r = f.vehicle.nominal.rotors[0];
  return r.speed(f.vehicle.weight() / f.vehicle.nominal.rotor_count());
}

void each_rotor(FamilyFlight& f, const std::function<void(RotorChange&, int)>& change, int board) {
  for (int i = 0; i < f.vehicle.nominal.rotor_count(); ++i) {
    if (board >= 0 && f.vehicle.nominal.rotors[static_cast<std::size_t>(i)].board != board) continue;
    RotorChange c;
    c.rotor = i + 1;
    change(c, i);
    f.world.rotors.push_back(c);
  }
}

RotorChange some_rotor(const FamilyFlight& f, const Shape& s, int k) {
  RotorChange c;
  c.rotor = s.whole(k, 1, f.vehicle.nominal.rotor_count());
  return c;
}

}  // namespace omniflight::proof
