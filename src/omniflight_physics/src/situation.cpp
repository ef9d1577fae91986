#include "omniflight_physics/situation.hpp"

namespace omniflight::physics {

void prepare(const vehicle::Vehicle& vehicle, const RigidState& body, double alpha,
             std::span<const double> rotor_speed, std::span<const double> rotor_acceleration,
             const Environment& environment, Situation& out) {
  out.body = body;
  out.R_WB = body.q_WB.toRotationMatrix();
  out.v_WB_B = out.R_WB.transpose() * body.v_WB_W;
  out.g_B = -environment.gravity * out.R_WB.row(2).transpose();
  out.alpha = alpha;
  out.mass = vehicle.mass;
  out.inertia = vehicle.inertia;
  out.environment = environment;
  out.rotor_count = vehicle.rotor_count();
  const double c = std::cos(alpha), s = std::sin(alpha);
  for (int i = 0; i < out.rotor_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const vehicle::Rotor& rotor = vehicle.rotors[k];
    RotorSituation& r = out.rotors[k];
    r.p_BR = rotor.p_BR;
    r.tilt_axis_B = Vec3::Zero();
    r.n_B = rotor.axis_B;
    if (rotor.tilts) {
      const Vec3& t = rotor.tilt_axis_B;
      r.tilt_axis_B = t;
      r.n_B = c * rotor.axis_B + s * t.cross(rotor.axis_B) + (1.0 - c) * t.dot(rotor.axis_B) * t;
    }
    r.speed = k < rotor_speed.size() ? rotor_speed[k] : 0.0;
    r.acceleration = k < rotor_acceleration.size() ? rotor_acceleration[k] : 0.0;
    r.thrust = rotor.thrust(r.speed);
    r.spin = rotor.spin;
    r.drag_ratio = rotor.drag_ratio;
    r.radius = rotor.radius;
    r.thrust_coefficient = rotor.thrust_coefficient;
    r.board = rotor.board;
  }
}

Vec6 rotor_wrench(const Situation& s) {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (const RotorSituation& r : s.all_rotors()) {
    const Vec3 f = r.thrust * r.n_B;
    force += f;
    torque += r.p_BR.cross(f) + r.spin * r.drag_ratio * f;
  }
  Vec6 w;
  w << force, torque;
  return w;
}

}  // namespace omniflight::physics
