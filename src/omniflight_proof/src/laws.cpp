#include "laws.hpp"

namespace omniflight::proof {

void add_law(const Law& law, const Motion& m, BodyWrench& out) {
  const Vec3 axis = law.axis.normalized();
  const auto world_force = [&](const Vec3& force_W) { out.force_B += m.R_WB.transpose() * force_W; };
  switch (law.kind) {
    case Law::Kind::magnus:
      out.force_B += law.gain * m.rotor_circulation_B.cross(m.R_WB.transpose() * m.v_W);
      break;
    case Law::Kind::lift: {
      const double speed = m.v_W.norm();
      if (speed < 1e-9) break;
      const Vec3 along = m.v_W / speed, up = m.R_WB * axis;
      world_force(law.gain * speed * speed * (up - up.dot(along) * along));
      break;
    }
    case Law::Kind::well: {
      const double distance = (m.p_W - law.center_W).norm() / law.scale;
      world_force(law.gain * std::exp(-0.5 * distance * distance) * axis);
      break;
    }
    case Law::Kind::corrugation:
      world_force(law.gain *
                  std::sin(2 * kPi * (m.p_W - law.center_W).dot(law.wave_W.normalized()) / law.scale) * axis);
      break;
    case Law::Kind::compass:
      out.torque_B += law.gain * Vec3::UnitX().cross(m.R_WB.transpose() * axis);
      break;
    case Law::Kind::flywheel:
      out.torque_B -= m.w_B.cross(law.gain * axis);
      break;
    case Law::Kind::pulsation:
      out.force_B += law.gain * std::sin(2 * kPi * law.scale * m.t) * axis;
      break;
    case Law::Kind::heave_lock:
      world_force(-law.gain * m.v_W.z() * (m.p_W - law.center_W).head<2>().norm() * axis);
      break;
    case Law::Kind::cushion:
      world_force(law.gain * std::exp(-std::max(-3.0, (m.p_W - law.center_W).dot(axis) / law.scale)) * axis);
      break;
    case Law::Kind::friction:
      if (const double speed = m.v_W.norm(); speed > 1e-9)
        world_force(-law.gain * std::tanh(speed / law.scale) / speed * m.v_W);
      break;
    case Law::Kind::rail:
      world_force(-law.gain * std::tanh(m.v_W.dot(axis) / law.scale) * axis);
      break;
    case Law::Kind::torsion:
    case Law::Kind::torsion_cubic: {
      double turned = std::atan2(m.R_WB(1, 0), m.R_WB(0, 0)) - law.center_W.x();
      turned = std::remainder(turned, 2 * kPi);
      if (law.kind == Law::Kind::torsion_cubic) turned += turned * turned * turned / (law.scale * law.scale);
      out.torque_B -= law.gain * turned * (m.R_WB.transpose() * Vec3::UnitZ());
      break;
    }
    case Law::Kind::crosswise:
      world_force(law.gain * Vec3::UnitZ().cross(m.v_W));
      break;
    case Law::Kind::gyration:
      out.torque_B += law.gain * m.rotor_speed_sum * axis.cross(m.w_B);
      break;
  }
}

void add_spring(const Spring& s, const Motion& m, BodyWrench& out) {
  const Vec3 end_W = m.p_W + m.R_WB * s.attachment_B;
  const Vec3 velocity_W = m.v_W + m.R_WB * m.w_B.cross(s.attachment_B);
  const Vec3 span = s.anchor_W - end_W;
  const double length = span.norm();
  if (length < 1e-9 || (s.rope && length <= s.rest_length)) return;
  const Vec3 along = span / length;
  const double stretch = length - s.rest_length;
  double tension =
      s.stiffness * stretch * (1 + s.hardening * std::abs(stretch)) - s.damping * velocity_W.dot(along);
  if (s.rope) tension = std::max(0.0, tension);
  out.add_at(m.R_WB.transpose() * (tension * along), s.attachment_B);
}

void add_pull(const Pull& p, const Motion& m, BodyWrench& out) {
  if (m.t < p.from || m.t >= p.until) return;
  const double share = p.fades > 0 ? std::min(1.0, (p.until - m.t) / p.fades) : 1.0;
  out.add_at(m.R_WB.transpose() * (share * p.force_W), p.attachment_B);
}

}  // namespace omniflight::proof
