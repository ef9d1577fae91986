#include "omniflight_core/frames.hpp"

namespace omniflight {

Quat shortest_rotation(const Vec3& from, const Vec3& to) { return Quat::FromTwoVectors(from, to); }

Quat exp_rotation(const Vec3& phi) {
  const double angle2 = phi.squaredNorm();
  const double angle = std::sqrt(angle2);
  // sin(angle/2)/angle, by its series where the quotient loses digits
  const double k = angle < 1e-4 ? 0.5 - angle2 / 48.0 : std::sin(0.5 * angle) / angle;
  return Quat(std::cos(0.5 * angle), k * phi.x(), k * phi.y(), k * phi.z());
}

Vec3 log_rotation(const Quat& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double w = sign * q.w();
  const double n = v.norm();
  if (n < 1e-9) return 2.0 * v / w;
  return 2.0 * std::atan2(n, w) / n * v;
}

Mat3 right_jacobian(const Vec3& phi) {
  const double a2 = phi.squaredNorm();
  const double a = std::sqrt(a2);
  const double k1 = a < 1e-3 ? 0.5 - a2 / 24.0 : (1.0 - std::cos(a)) / a2;
  const double k2 = a < 1e-3 ? 1.0 / 6.0 - a2 / 120.0 : (a - std::sin(a)) / (a2 * a);
  const Mat3 s = skew(phi);
  return Mat3::Identity() - k1 * s + k2 * s * s;
}

Mat3 right_jacobian_inverse(const Vec3& phi) {
  const double a2 = phi.squaredNorm();
  const double a = std::sqrt(a2);
  const double k =
      a < 1e-3 ? 1.0 / 12.0 + a2 / 720.0 : 1.0 / a2 - (1.0 + std::cos(a)) / (2.0 * a * std::sin(a));
  const Mat3 s = skew(phi);
  return Mat3::Identity() + 0.5 * s + k * s * s;
}

Vec3 jacobian_rate_times(const Vec3& phi, const Vec3& dphi) {
  // J = I - k1 S + k2 S^2 with k1(a), k2(a) of right_jacobian(), a = |phi|, S = skew(phi): its rate times
  // dphi is (k1'/a) (phi . dphi) and (k2'/a) (phi . dphi) on S dphi and S^2 dphi, and k2 dphi x (S dphi).
  const double a2 = phi.squaredNorm(), a = std::sqrt(a2);
  double k2, c1, c2;  // k2, k1' / a, k2' / a
  if (a < 0.1) {      // series: the closed forms lose digits; what is left out is below 1e-13
    k2 = 1.0 / 6.0 - a2 * (1.0 / 120.0 - a2 * (1.0 / 5040.0 - a2 / 362880.0));
    c1 = -1.0 / 12.0 + a2 * (1.0 / 180.0 - a2 * (1.0 / 6720.0 - a2 / 453600.0));
    c2 = -1.0 / 60.0 + a2 * (1.0 / 1260.0 - a2 * (1.0 / 60480.0 - a2 / 4989600.0));
  } else {
    const double s = std::sin(a), c = 1.0 - std::cos(a);
    k2 = (a - s) / (a2 * a);
    c1 = (a * s - 2.0 * c) / (a2 * a2);
    c2 = (a * c - 3.0 * (a - s)) / (a2 * a2 * a);
  }
  const Vec3 across = phi.cross(dphi);
  const double along = phi.dot(dphi);
  return -c1 * along * across + c2 * along * phi.cross(across) + k2 * dphi.cross(across);
}

Vec3 roll_pitch_yaw(const Quat& q) {
  const double sin_pitch = std::clamp(2.0 * (q.w() * q.y() - q.z() * q.x()), -1.0, 1.0);
  return {std::atan2(2.0 * (q.w() * q.x() + q.y() * q.z()), 1.0 - 2.0 * (q.x() * q.x() + q.y() * q.y())),
          std::asin(sin_pitch),
          std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()), 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()))};
}

Quat from_roll_pitch_yaw(const Vec3& rpy) {
  return Quat(Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
              Eigen::AngleAxisd(rpy.x(), Vec3::UnitX()));
}

bool is_finite(const RigidState& s) {
  return s.p_WB.allFinite() && s.q_WB.coeffs().allFinite() && s.v_WB_W.allFinite() && s.w_WB_B.allFinite() &&
         s.q_WB.norm() > 0.5;
}

std::string what_is_not_finite(const RigidState& s) {
  const struct {
    const char *name, *unit;
    const Vec3& value;
  } vectors[] = {
      {"position", "m", s.p_WB}, {"velocity", "m/s", s.v_WB_W}, {"angular velocity", "rad/s", s.w_WB_B}};
  for (const auto& [name, unit, value] : vectors)
    for (int k = 0; k < 3; ++k)
      if (!std::isfinite(value[k]))
        return std::string(name) + ' ' + "xyz"[k] + " is " + std::to_string(value[k]) + ' ' + unit;
  for (int k = 0; k < 4; ++k)
    if (!std::isfinite(s.q_WB.coeffs()[k]))
      return std::string("attitude q") + "xyzw"[k] + " is " + std::to_string(s.q_WB.coeffs()[k]);
  if (!(s.q_WB.norm() > 0.5))
    return "attitude has the length " + std::to_string(s.q_WB.norm()) + " instead of 1";
  return {};
}

}  // namespace omniflight
