#include "omniflight_planning/flatness.hpp"

#include "omniflight_allocation/actuation.hpp"

namespace omniflight::planning {
namespace {

/// Quaternion product of coefficient vectors (w, x, y, z), of any norm: derivatives of quaternions are none.
Eigen::Vector4d times(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  const Vec3 u = a.tail<3>(), v = b.tail<3>();
  Eigen::Vector4d out;
  out << a[0] * b[0] - u.dot(v), a[0] * v + b[0] * u + u.cross(v);
  return out;
}

Eigen::Vector4d inverse(const Eigen::Vector4d& q) {
  return Eigen::Vector4d(q[0], -q[1], -q[2], -q[3]) / q.squaredNorm();
}

/// A quaternion (of any norm) and its first two derivatives by time.
struct Jet {
  Eigen::Vector4d q, dq, ddq;
};

Jet times(const Jet& a, const Jet& b) {
  return {times(a.q, b.q), times(a.dq, b.q) + times(a.q, b.dq),
          times(a.ddq, b.q) + 2.0 * times(a.dq, b.dq) + times(a.q, b.ddq)};
}

/// Shortest rotation from upright to the thrust t [N/kg]: (|t| + t_z, e_z x t), with its derivatives.
Jet swing(const Vec3& t, const Vec3& dt, const Vec3& ddt) {
  const double n = t.norm(), dn = t.dot(dt) / n, ddn = (dt.dot(dt) + t.dot(ddt) - dn * dn) / n;
  return {Eigen::Vector4d(n + t.z(), -t.y(), t.x(), 0), Eigen::Vector4d(dn + dt.z(), -dt.y(), dt.x(), 0),
          Eigen::Vector4d(ddn + ddt.z(), -ddt.y(), ddt.x(), 0)};
}

Jet turn_about_z(double yaw, double dyaw, double ddyaw) {
  const Eigen::Vector4d q(std::cos(0.5 * yaw), 0, 0, std::sin(0.5 * yaw));
  const Eigen::Vector4d normal(-q[3], 0, 0, q[0]);
  return {q, 0.5 * dyaw * normal, 0.5 * ddyaw * normal - 0.25 * dyaw * dyaw * q};
}

}  // namespace

Quat FlatVehicle::upright(double heading) const {
  return (Quat(Eigen::AngleAxisd(heading, Vec3::UnitZ())) * shortest_rotation(thrust_axis_B, Vec3::UnitZ()))
      .normalized();
}

double FlatVehicle::lean(const Quat& q_WB) const {
  const Vec3 n = q_WB * thrust_axis_B;
  return std::atan2(n.head<2>().norm(), n.z());
}

std::optional<double> FlatVehicle::heading(const Quat& q_WB, double tolerance) const {
  if (!(lean(q_WB) <= tolerance)) return std::nullopt;
  const Quat turn = q_WB * upright(0.0).conjugate();
  const double half = std::atan2(turn.z(), turn.w());
  return std::remainder(2.0 * half, 2.0 * kPi);
}

Result<std::optional<FlatVehicle>> flat_vehicle(const vehicle::Vehicle& vehicle, double alpha) {
  const auto actuation = allocation::actuation_at(vehicle, alpha);
  if (!actuation) return Failure(actuation.error());
  if (actuation->kind != allocation::ActuationKind::underactuated) return std::optional<FlatVehicle>();
  return std::optional(FlatVehicle{actuation->thrust_axis_B, vehicle.center_of_mass});
}

Reference flat_reference(const FlatMotion& m, const FlatVehicle& vehicle) {
  const Vec3 thrust = m[2].head<3>() + kGravity * Vec3::UnitZ();
  const Quat level = vehicle.upright(0.0);
  const Eigen::Vector4d constant(level.w(), level.x(), level.y(), level.z());
  const Jet q =
      times(times(swing(thrust, m[3].head<3>(), m[4].head<3>()), turn_about_z(m[0][3], m[1][3], m[2][3])),
            Jet{constant, Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()});
  // dq = 1/2 w q in world axes, whatever the norm of q adds to the real part
  const Eigen::Vector4d rate = times(q.dq, inverse(q.q));
  const Vec3 w_W = 2.0 * rate.tail<3>();
  const Vec3 dw_W = 2.0 * (times(q.ddq, inverse(q.q)) - times(rate, rate)).tail<3>();

  Reference r;
  r.q_WB = Quat(q.q[0], q.q[1], q.q[2], q.q[3]).normalized();
  r.w_WB_B = r.q_WB.conjugate() * w_W;
  r.dw_WB_B = r.q_WB.conjugate() * dw_W;  // the derivative of w in the body is that of w in the world, turned
  const Vec3 p_BBcm_W = r.q_WB * vehicle.p_BBcm;
  r.p_WB = m[0].head<3>() - p_BBcm_W;
  r.v_WB_W = m[1].head<3>() - w_W.cross(p_BBcm_W);
  r.a_WB_W = m[2].head<3>() - dw_W.cross(p_BBcm_W) - w_W.cross(w_W.cross(p_BBcm_W));
  return r;
}

double largest_lean(const std::vector<TrajectoryKnot>& knots, const FlatVehicle& vehicle) {
  double most = 0.0;
  for (const TrajectoryKnot& knot : knots) most = std::max(most, vehicle.lean(knot.reference.q_WB));
  return most;
}

}  // namespace omniflight::planning
