// A point mass on a massless cable that stays taut.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class SlungLoad final : public MemoryEffect<SlungLoad, 6> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "slung_load",
        .term = "slung load",
        .equation =
            "T = m_l (q.(g - a_A) + L |dq|^2), dF = T q at r_A; d2q = (I - q q^T)(g - a_A)/L - |dq|^2 q - c "
            "dq",
        .latex =
            R"(T = m_l\,(q\cdot(g-a_A)+L|\dot q|^2),\ \Delta F = R^T T q;\quad \ddot q = \tfrac1L(I-qq^T)(g-a_A)-|\dot q|^2q-c\,\dot q)",
        .source =
            "Sreenath, Lee and Kumar 2013; Lee 2014: geometric control of a quadrotor with a cable-suspended "
            "load",
        .parameters = {{"mass", "m_l", "kg", 0, 5, 0.15, 0, true},
                       {"length", "L", "m", 0.05, 10, 1, 1, false},
                       {"damping", "c", "1/s", 0, 5, 0.1, 0.1, false},
                       {"attachment_x", "r_Ax", "m", -0.5, 0.5, 0, 0, false},
                       {"attachment_y", "r_Ay", "m", -0.5, 0.5, 0, 0, false},
                       {"attachment_z", "r_Az", "m", -0.5, 0.5, 0, 0, false}},
        .signals = {"attitude", "acc", "gyro"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"payload_mass", "hung_cable", "cable_pendulum"},
        .separated_by = "stop after a lateral move and wait: it goes on swinging at sqrt(g/L)"};
    return info;
  }

  // memory: direction q of the cable from the attachment to the load, world axes, and its rate [1/s]
  template <class T>
  void start(const Situation&, const T*, T* x) const {
    for (int k = 0; k < 6; ++k) x[k] = T(k == 2 ? -1.0 : 0.0);
  }
  template <class T>
  void rate(const Situation& s, const T* theta, const T* x, T* dx) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const V> q(x), dq(x + 3);
    const V r(theta[3], theta[4], theta[5]);
    const V w = s.body.w_WB_B.cast<T>();
    const V a_A = s.a_WB_B.cast<T>() + s.dw_WB_B.cast<T>().cross(r) + w.cross(w.cross(r));
    const V pull = s.R_WB.cast<T>() * V(s.g_B.cast<T>() - a_A);
    // the last two terms bring rounding errors back to |q| = 1 and vanish on it
    const T stretch = T(0.5) * (q.squaredNorm() - T(1)), slip = q.dot(dq);
    const V ddq = (pull - q.dot(pull) * q) / theta[1] - dq.squaredNorm() * q - theta[2] * dq -
                  (T(40) * slip + T(400) * stretch) * q;
    for (int k = 0; k < 3; ++k) {
      dx[k] = dq[k];
      dx[k + 3] = ddq[k];
    }
  }
  template <class T>
  void wrench(const Situation& s, const T* theta, const T* x, WrenchT<T>& out) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const V q = s.R_WB.transpose().cast<T>() * Eigen::Map<const V>(x);
    const V r(theta[3], theta[4], theta[5]);
    const V w = s.body.w_WB_B.cast<T>();
    const T swing = Eigen::Map<const V>(x + 3).squaredNorm();
    // tension less its part that answers to the unknown acceleration, which goes into the inertia
    const T tension = theta[0] * (q.dot(s.g_B.cast<T>()) + theta[1] * swing - q.dot(w.cross(w.cross(r))));
    const V arm = r.cross(q);
    out.force_B += tension * q;
    out.torque_B += tension * arm;
    Eigen::Matrix<T, 6, 1> line;
    line << q, arm;
    out.has_inertia = true;
    out.inertia += theta[0] * (line * line.transpose());
  }
};

}  // namespace

const Effect& slung_load_effect() {
  static const SlungLoad effect;
  return effect;
}

}  // namespace omniflight::physics
