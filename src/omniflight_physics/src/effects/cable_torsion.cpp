// A cable that is twisted and bent by the attitude of the vehicle it hangs from.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class CableTorsion final : public WrenchEffect<CableTorsion> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "cable_torsion",
        .term = "cable torsion and bending",
        .equation =
            "dM = -(k_t (psi - psi0) + d dpsi/dt) j + k_b phi (e_z x R^T e3)/|e_z x R^T e3|, psi = 2 "
            "atan2(q_z, q_w), j = dpsi/dtheta, phi = angle of body z from the vertical",
        .latex =
            R"(\Delta\tau = -\big(k_t(\psi-\psi_0)+d\,\dot\psi\big)j + k_b\,\varphi\,\frac{e_z\times R^Te_3}{|e_z\times R^Te_3|},)"
            R"(\quad \psi = 2\,\mathrm{atan2}(q_z,q_w),\; \dot\psi = j\cdot\omega)",
        .source =
            "twist about the cable and bending, each from its potential energy (k_t psi^2/2, k_b phi^2/2): "
            "the bent cable transmits twist as a constant-velocity joint",
        .parameters = {{"torsion", "k_t", "Nm/rad", 0, 0.5, 0.02, 0, true},
                       {"bending", "k_b", "Nm/rad", 0, 0.5, 0.02, 0, true},
                       {"damping", "d", "Nm s/rad", 0, 0.1, 0.001, 0, true},
                       {"rest_angle", "psi_0", "rad", -3.2, 3.2, 0, 0, false}},
        .signals = {"attitude", "gyro"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"drag_torque_scale", "com_offset"},
        .separated_by = "slow yaw ramp of 90 deg both ways; tilt at two headings"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const Quat& q = s.body.q_WB;
    const double share = q.w() * q.w() + q.z() * q.z();  // zero upside down, where twist has no meaning
    if (share > 1e-9) {
      const double flip = q.w() < 0 ? -1.0 : 1.0;
      const double psi = 2.0 * std::atan2(flip * q.z(), flip * q.w());
      const Vec3 j((q.z() * q.x() - q.w() * q.y()) / share, (q.w() * q.x() + q.z() * q.y()) / share, 1.0);
      const T twist = theta[0] * (T(psi) - theta[3]) + theta[2] * T(j.dot(s.body.w_WB_B));
      out.torque_B -= twist * j.cast<T>();
    }
    const Vec3 up = s.R_WB.row(2).transpose();
    const Vec3 axis = Vec3::UnitZ().cross(up);
    const double sine = axis.norm();
    if (sine > 1e-12) out.torque_B += theta[1] * (std::atan2(sine, up.z()) / sine * axis).cast<T>();
  }
};

}  // namespace

const Effect& cable_torsion_effect() {
  static const CableTorsion effect;
  return effect;
}

}  // namespace omniflight::physics
