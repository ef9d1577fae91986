// Every field of a World once: key with unit, bounds. Reader, checker and writer visit this list.
#pragma once

#include "omniflight_proof/world.hpp"

namespace omniflight::proof {

template <class V>
void visit(V& v, BodyChange& b) {
  v.number("payload_kg", b.payload, 0, 100, "kg");
  v.vec3("payload_position_m", b.payload_p_B, -5, 5, "m");
  v.number("payload_radius_m", b.payload_radius, 1e-3, 1, "m");
  v.vec3("com_shift_m", b.com_shift_B, -0.5, 0.5, "m");
  v.vec3("inertia_scale", b.inertia_scale, 0.2, 5, "1");
  v.angles("inertia_turn_deg", b.inertia_turn_B, -45, 45);
  v.number("sloshing_mass_kg", b.sloshing_mass, 0, 10, "kg");
  v.number("sloshing_frequency_hz", b.sloshing_frequency, 0.3, 40, "Hz");
  v.number("sloshing_damping_ratio", b.sloshing_damping_ratio, 0, 2, "1");
}
template <class V>
void visit(V& v, FlexibleArms& a) {
  v.number("pod_mass_kg", a.pod_mass, 1e-4, 10, "kg");
  v.number("frequency_hz", a.frequency, 3, 200, "Hz");
  v.number("damping_ratio", a.damping_ratio, 0, 2, "1");
  v.number("root", a.root, 0, 0.9, "1");
}
template <class V>
void visit(V& v, RotorChange& r) {
  v.integer("rotor", r.rotor, 0, 16);
  v.number("thrust_scale", r.thrust_scale, 0, 3, "1");
  v.number("reverse_scale", r.reverse_scale, 0, 3, "1");
  v.number("drag_torque_scale", r.drag_torque_scale, 0, 5, "1");
  v.number("exponent", r.exponent, 1, 3, "1");
  v.number("time_constant_s", r.time_constant, -1, 1, "s");
  v.number("slowing_factor", r.slowing_factor, 0.2, 5, "1");
  v.number("delay_s", r.delay, 0, 0.5, "s");
  v.number("dead_speed_radps", r.dead_speed, 0, 2000, "rad/s");
  v.number("max_speed_radps", r.max_speed, 0, 1e5, "rad/s");
  v.number("quantum_radps", r.quantum, 0, 1000, "rad/s");
  v.number("inertia_kgm2", r.inertia, 0, 0.01, "kg m2");
  v.angles("axis_tilt_deg", r.axis_tilt_B, -45, 45);
  v.vec3("shift_m", r.shift_B, -0.2, 0.2, "m");
  v.number("fails_from_s", r.fails_from, -1, 1e6, "s");
  v.number("fails_until_s", r.fails_until, -1, 1e6, "s");
  v.number("linear_share", r.linear_share, -0.9, 0.95, "1");
  v.number("drag_exponent", r.drag_exponent, -2, 2, "1");
  v.vec3("lean_radpN", r.lean_B, -1, 1, "rad/N");
  v.number("slew_radps2", r.slew, 0, 1e7, "rad/s2");
  v.number("hold_s", r.hold, 0, 0.5, "s");
  v.number("restart_s", r.restart, 0, 2, "s");
  v.number("thrust_lag_s", r.thrust_lag, 0, 0.5, "s");
  v.number("thrust_lead", r.thrust_lead, -1, 2, "1");
}
template <class V>
void visit(V& v, TiltChange& t) {
  v.angle("offset_deg", t.offset, -30, 30);
  v.number("time_constant_s", t.time_constant, 0, 5, "s");
  v.angle("backlash_deg", t.backlash, 0, 20);
  v.number("rate_scale", t.rate_scale, 0.02, 10, "1");
  v.number("loss", t.loss, -0.5, 0.9, "1");
  v.angle("loss_center_deg", t.loss_center, -180, 180);
  v.angle("loss_width_deg", t.loss_width, 0, 180);
}
template <class V>
void visit(V& v, BatterySag& b) {
  v.number("nominal_V", b.nominal, 1, 100, "V");
  v.number("resistance_ohm", b.resistance, 0, 1, "ohm");
  v.number("drop_V_per_J", b.drop, 0, 1, "V/J");
  v.number("polarisation_ohm", b.polarisation, 0, 1, "ohm");
  v.number("polarisation_time_s", b.polarisation_time, 0.01, 1000, "s");
  v.number("sensitivity", b.sensitivity, 0, 2, "1");
  v.number("efficiency", b.efficiency, 0.05, 1, "1");
}
template <class V>
void visit(V& v, Blades& b) {
  v.number("solidity_slope", b.solidity_slope, 0.05, 3, "1/rad");
  v.flag("edgewise", b.edgewise);
  v.number("flapping", b.flapping, 0, 2, "1");
  v.number("hub_stiffness_Nm_per_rad", b.hub_stiffness, 0, 50, "N m/rad");
  v.number("inflow_time_s", b.inflow_time, 0, 0.5, "s");
}
template <class V>
void visit(V& v, Jets& j) {
  v.number("strength", j.strength, 0, 3, "1");
  v.number("spread", j.spread, 0, 0.5, "1");
  v.number("body_drag_m2", j.body_drag, 0, 1, "m2");
}
template <class V>
void visit(V& v, Planes& p) {
  v.number("floor", p.floor, 0, 8, "1");
  v.number("ceiling", p.ceiling, 0, 8, "1");
  v.number("ceiling_z_m", p.ceiling_z, -100, 100, "m");
}
template <class V>
void visit(V& v, Neighbour& n) {
  v.vec3("position_m", n.p_W, -100, 100, "m");
  v.vec3("velocity_mps", n.v_W, -20, 20, "m/s");
  v.number("thrust_N", n.thrust, 0, 1000, "N");
  v.number("radius_m", n.radius, 0.01, 5, "m");
  v.number("appears_s", n.appears, 0, 1e9, "s");
  v.number("leaves_s", n.leaves, 0, 1e9, "s");
}
template <class V>
void visit(V& v, Airframe& a) {
  v.vec3("drag_area_m2", a.drag_area_B, 0, 10, "m2");
  v.number("round_area_m2", a.round_area, 0, 10, "m2");
  v.vec3("center_m", a.center_B, -2, 2, "m");
  v.number("rotation_damping_Nms2", a.rotation_damping, 0, 10, "N m s2");
}
template <class V>
void visit(V& v, RotorAir& r) {
  v.number("drag_kgprad", r.drag, 0, 0.1, "kg/rad");
  v.number("flapping_kgmprad", r.flapping, 0, 0.1, "kg m/rad");
  v.number("descent_loss", r.descent_loss, 0, 0.9, "1");
  v.number("descent_center", r.descent_center, 0.05, 5, "1");
  v.number("descent_width", r.descent_width, 0.01, 5, "1");
}
template <class V>
void visit(V& v, Gust& g) {
  v.number("start_s", g.start, 0, 1e6, "s");
  v.number("duration_s", g.duration, 0.01, 1e4, "s");
  v.vec3("velocity_mps", g.velocity_W, -30, 30, "m/s");
}
template <class V>
void visit(V& v, Wind& w) {
  v.vec3("velocity_mps", w.velocity_W, -30, 30, "m/s");
  v.number("reference_height_m", w.reference_height, 0.01, 100, "m");
  v.number("profile_exponent", w.profile_exponent, 0, 1, "1");
  v.number("gust_rms_mps", w.gust_rms, 0, 10, "m/s");
  v.number("gust_length_m", w.gust_length, 0.01, 1000, "m");
  v.list("gusts", w.gusts, 32);
}
template <class V>
void visit(V& v, Turbulence& t) {
  using Kind = Turbulence::Kind;
  v.choice("kind", t.kind,
           {{"ou", Kind::ou}, {"dryden", Kind::dryden}, {"heavy", Kind::heavy}, {"bursts", Kind::bursts}});
  v.number("force_rms_N", t.force_rms, 0, 100, "N");
  v.number("torque_rms_Nm", t.torque_rms, 0, 10, "N m");
  v.number("correlation_time_s", t.correlation_time, 0.001, 100, "s");
}
template <class V>
void visit(V& v, Cable& c) {
  v.number("linear_density_kgpm", c.linear_density, 1e-4, 5, "kg/m");
  v.number("length_m", c.length, 0.1, 10, "m");
  v.integer("links", c.links, 4, 48);
  v.number("diameter_m", c.diameter, 1e-3, 0.1, "m");
  v.vec3("attachment_m", c.attachment_B, -2, 2, "m");
  v.angle("initial_bend_deg", c.initial_bend, 0.5, 20);
  v.number("bending_stiffness_Nm2", c.bending_stiffness, 0, 1, "N m2");
  v.number("damping_Nms_per_rad", c.damping, 0, 1, "N m s/rad");
  v.number("floor_friction", c.floor_friction, 0, 2, "1");
  v.number("drag_coefficient", c.drag_coefficient, 0, 5, "1");
}
template <class V>
void visit(V& v, OverheadRope& r) {
  v.number("linear_density_kgpm", r.linear_density, 1e-4, 5, "kg/m");
  v.number("length_m", r.length, 0.1, 20, "m");
  v.integer("links", r.links, 4, 48);
  v.vec3("anchor_m", r.anchor_W, -100, 100, "m");
  v.vec3("attachment_m", r.attachment_B, -2, 2, "m");
  v.number("damping_Nms_per_rad", r.damping, 0, 1, "N m s/rad");
}
template <class V>
void visit(V& v, SlungBall& b) {
  v.number("mass_kg", b.mass, 1e-4, 100, "kg");
  v.number("length_m", b.length, 0.02, 10, "m");
  v.number("radius_m", b.radius, 1e-3, 1, "m");
  v.vec3("attachment_m", b.attachment_B, -2, 2, "m");
  v.number("damping_Nms_per_rad", b.damping, 0, 10, "N m s/rad");
  v.integer("links", b.links, 1, 24);
}
template <class V>
void visit(V& v, Spring& s) {
  v.vec3("anchor_m", s.anchor_W, -100, 100, "m");
  v.vec3("attachment_m", s.attachment_B, -2, 2, "m");
  v.number("stiffness_Npm", s.stiffness, 0, 1e5, "N/m");
  v.number("damping_Nspm", s.damping, 0, 1e3, "N s/m");
  v.number("rest_length_m", s.rest_length, 0, 100, "m");
  v.flag("rope", s.rope);
  v.number("hardening_pm", s.hardening, 0, 1e4, "1/m");
}
template <class V>
void visit(V& v, Pull& p) {
  v.vec3("force_N", p.force_W, -100, 100, "N");
  v.vec3("attachment_m", p.attachment_B, -2, 2, "m");
  v.number("from_s", p.from, 0, 1e6, "s");
  v.number("until_s", p.until, 0, 1e9, "s");
  v.number("fades_s", p.fades, 0, 1e6, "s");
}
template <class V>
void visit(V& v, Law& l) {
  using Kind = Law::Kind;
  v.choice("kind", l.kind,
           {{"magnus", Kind::magnus},
            {"lift", Kind::lift},
            {"well", Kind::well},
            {"corrugation", Kind::corrugation},
            {"compass", Kind::compass},
            {"flywheel", Kind::flywheel},
            {"pulsation", Kind::pulsation},
            {"heave_lock", Kind::heave_lock},
            {"cushion", Kind::cushion},
            {"friction", Kind::friction},
            {"rail", Kind::rail},
            {"torsion", Kind::torsion},
            {"torsion_cubic", Kind::torsion_cubic},
            {"crosswise", Kind::crosswise},
            {"gyration", Kind::gyration}});
  v.number("gain", l.gain, -1000, 1000, "unit of the kind");
  v.vec3("axis", l.axis, -1, 1, "1");
  v.vec3("center_m", l.center_W, -100, 100, "m");
  v.vec3("wave", l.wave_W, -1, 1, "1");
  v.number("scale", l.scale, 1e-3, 1000, "m or Hz");
}
template <class V>
void visit(V& v, SensorFault& f) {
  using Sensor = SensorFault::Sensor;
  v.choice("sensor", f.sensor,
           {{"imu", Sensor::imu},
            {"mocap", Sensor::mocap},
            {"rotor_speed", Sensor::rotor_speed},
            {"battery", Sensor::battery}});
  v.integer("rotor", f.rotor, 0, 16);
  v.number("from_s", f.from, 0, 1e9, "s");
  v.number("until_s", f.until, 0, 1e9, "s");
  v.number("scale", f.scale, -10, 10, "1");
  v.flag("frozen", f.frozen);
  v.flag("silent", f.silent);
}
template <class V>
void visit(V& v, SensorChange& s) {
  v.vec3("accelerometer_bias_mps2", s.accelerometer_bias, -5, 5, "m/s2");
  v.vec3("accelerometer_scale", s.accelerometer_scale, -0.5, 0.5, "1");
  v.vec3("gyro_bias_radps", s.gyro_bias, -1, 1, "rad/s");
  v.vec3("gyro_scale", s.gyro_scale, -0.5, 0.5, "1");
  v.vec3("imu_position_m", s.imu_p_B, -1, 1, "m");
  v.number("imu_low_pass_hz", s.imu_low_pass, 0, 1000, "Hz");
  v.number("vibration_mps2", s.vibration, 0, 100, "m/s2");
  v.integer("vibration_rotor", s.vibration_rotor, 0, 16);
  v.angles("mocap_turn_deg", s.mocap_turn_B, -30, 30);
  v.number("pose_repeat", s.pose_repeat, 0, 0.95, "1");
  v.number("outlier_share", s.outlier_share, 0, 0.5, "1");
  v.number("outlier_size", s.outlier_size, 0, 100, "1");
  v.angles("mocap_rotation_deg", s.mocap_rotation_W, -30, 30);
  v.vec3("mocap_offset_m", s.mocap_offset_B, -0.5, 0.5, "m");
  v.number("mocap_extra_latency_s", s.mocap_extra_latency, 0, 0.5, "s");
  v.number("board_clock_skew", s.board_clock_skew, -0.01, 0.01, "1");
  v.number("board_clock_offset_s", s.board_clock_offset, 0, 10, "s");
  v.number("noise_correlation_time_s", s.noise_correlation_time, 0, 10, "s");
  v.number("rotor_dropout", s.rotor_dropout, 0, 0.9, "1");
  v.number("imu_dropout", s.imu_dropout, 0, 0.9, "1");
  v.list("faults", s.faults, 32);
}
template <class V>
void visit(V& v, World& w) {
  v.text("name", w.name);
  v.number("timestep_s", w.timestep, 5e-5, 0.002, "s");
  v.choice("integrator", w.integrator, {{"euler", Integrator::euler}, {"implicit", Integrator::implicit}});
  v.number("floor_z_m", w.floor_z, -100, 100, "m");
  v.number("air_density_kgpm3", w.air_density, 0.1, 2, "kg/m3");
  v.number("settle_s", w.settle, 0, 60, "s");
  v.part("body", w.body);
  v.optional("flexible_arms", w.flexible_arms);
  v.list("rotors", w.rotors, 32);
  v.part("tilt", w.tilt);
  v.optional("battery", w.battery);
  v.optional("blades", w.blades);
  v.optional("jets", w.jets);
  v.optional("planes", w.planes);
  v.list("neighbours", w.neighbours, 8);
  v.optional("airframe", w.airframe);
  v.optional("rotor_air", w.rotor_air);
  v.optional("wind", w.wind);
  v.optional("turbulence", w.turbulence);
  v.optional("cable", w.cable);
  v.optional("overhead_rope", w.overhead_rope);
  v.optional("slung_ball", w.slung_ball);
  v.list("springs", w.springs, 32);
  v.list("pulls", w.pulls, 16);
  v.list("laws", w.laws, 16);
  v.part("sensors", w.sensors);
}

}  // namespace omniflight::proof
