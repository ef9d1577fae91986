#include "open_loop.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::Situation;

/// Acceleration (m/s^2, rad/s^2, body axes) of the model at a state, with rotors, tilt and vehicle of the
/// situation.
Vec6 acceleration(Situation& s, const RigidState& body, const OpenLoopModel& model) {
  s.body = body;
  s.R_WB = body.q_WB.toRotationMatrix();
  s.v_WB_B = s.R_WB.transpose() * body.v_WB_W;
  s.g_B = -s.environment.gravity * s.R_WB.row(2).transpose();
  physics::Wrench w;
  for (const auto& e : model.effects)
    if (e.effect->acts_on_wrench()) e.effect->add_wrench(s, e.theta.data(), w);
  const Vec3 &c = model.center_of_mass, &omega = body.w_WB_B;
  const Mat3 c_x = skew(c);
  Mat6 M;
  M << s.mass * Mat3::Identity(), -s.mass * c_x, s.mass * c_x, s.inertia - s.mass * c_x * c_x;
  M += w.moving_inertia(s);
  Vec6 force = physics::rotor_wrench(s);
  force.head<3>() += w.force_B + s.mass * (s.g_B - omega.cross(omega.cross(c)));
  force.tail<3>() +=
      w.torque_B + s.mass * c.cross(s.g_B - omega.cross(omega.cross(c))) - omega.cross(s.inertia * omega);
  return M.partialPivLu().solve(force);
}

}  // namespace

bool advance(const Flight& f, int k, const OpenLoopModel& model, int parts, RigidState& x) {
  const Situation& now = f.situation[static_cast<std::size_t>(k)];
  const Situation& next = f.situation[static_cast<std::size_t>(k + 1)];
  const double dt = 1.0 / (f.rate_hz * parts);
  Situation work = now;
  for (int part = 0; part < parts; ++part) {
    const double share = (part + 0.5) / parts;
    for (std::size_t r = 0; r < static_cast<std::size_t>(work.rotor_count); ++r) {
      work.rotors[r].thrust = now.rotors[r].thrust + share * (next.rotors[r].thrust - now.rotors[r].thrust);
      work.rotors[r].speed = now.rotors[r].speed + share * (next.rotors[r].speed - now.rotors[r].speed);
    }
    RigidState half = x;
    for (int stage = 0; stage < 2; ++stage) {
      const Vec6 nu = acceleration(work, half, model);
      const double h = stage == 0 ? 0.5 * dt : dt;
      const Vec3 v = half.v_WB_W, omega = half.w_WB_B;
      const Mat3 R = half.q_WB.toRotationMatrix();
      half.p_WB = x.p_WB + h * v;
      half.v_WB_W = x.v_WB_W + h * (R * nu.head<3>());
      half.w_WB_B = x.w_WB_B + h * nu.tail<3>();
      half.q_WB = (x.q_WB * exp_rotation(h * omega)).normalized();
    }
    x = half;
    if (!is_finite(x)) return false;
  }
  return true;
}

}  // namespace omniflight::diagnosis
