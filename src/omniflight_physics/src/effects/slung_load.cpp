// A point mass on a massless cable, which pulls while it is taut and is nothing while it is slack.
#include <cmath>

#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class SlungLoad final : public MemoryEffect<SlungLoad, 6, 1> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "slung_load",
        .term = "slung load",
        .equation =
            "T = m_l (q.(g - a_A) + L |dq|^2), dF = T q + m_l c L u at r_A, dM = m_l c L^2 q x u, u = dq - w "
            "x q; "
            "d2q = (I - q q^T)(g - a_A)/L - |dq|^2 q - c u; slack from T < 0 until |q| = 1 again: T = c = 0, "
            "d2q = (g - a_A)/L",
        .latex =
            R"(T = m_l\,(q\cdot(g-a_A)+L|\dot q|^2),\ \Delta F = R^T(Tq+m_lcLu),\ \Delta\tau = r_A\times\Delta F+R^T(m_lcL^2\,q\times u),\ u=\dot q-\omega\times q;\quad \ddot q = \tfrac1L(I-qq^T)(g-a_A)-|\dot q|^2q-c\,u;\quad \text{slack: } T=c=0,\ \ddot q=\tfrac1L(g-a_A))",
        .source =
            "Sreenath, Lee and Kumar 2013; Lee 2014: geometric control of a quadrotor with a cable-suspended "
            "load; taut and slack as in Sreenath, Michael and Kumar 2013 (hybrid), caught without rebound by "
            "a critically damped spring of 50 1/s; friction of the joint at the vehicle",
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
        .separated_by = "stop after a lateral move and wait: it goes on swinging at sqrt(g/L)",
        .words = {{"mass"}, [](const KnownValues& v) {
                    return "a load of " + in_mass(v("mass")) + " on a cable" +
                           (v.find("length") ? " of " + in_length(v("length")) : "");
                  }}};
    return info;
  }

  /// A load that swings by a fifth of a radian, at the rate of its pendulum.
  std::vector<double> start_spread(const double* theta) const override {
    const double angle = 0.2, rate = angle * std::sqrt(kGravity / theta[1]);
    return {angle, angle, 0, rate, rate, 0};
  }

  // memory: q, from the attachment to the load in world axes, as a share of the length: a unit vector while
  // the cable is taut; its rate [1/s]; and whether it is taut (1) or slack (0)
  template <class T>
  void start(const Situation&, const T*, T* x) const {
    for (int k = 0; k < 6; ++k) x[k] = T(k == 2 ? -1.0 : 0.0);
    x[6] = T(1);
  }
  template <class T>
  void rate(const Situation& s, const T* theta, const T* x, T* dx) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const V> q(x), dq(x + 3);
    V ddq = free_pull(s, theta) / theta[1];
    if (taut(x)) ddq -= tension_per_mass(s, theta, x) / theta[1] * q.normalized() + theta[2] * slip(s, x);
    for (int k = 0; k < 3; ++k) {
      dx[k] = dq[k];
      dx[k + 3] = ddq[k];
    }
  }
  template <class T>
  void wrench(const Situation& s, const T* theta, const T* x, WrenchT<T>& out) const {
    using V = Eigen::Matrix<T, 3, 1>;
    if (!taut(x)) return;
    const V q = s.R_WB.transpose().cast<T>() * Eigen::Map<const V>(x).normalized();
    const V r(theta[3], theta[4], theta[5]);
    const V w = s.body.w_WB_B.cast<T>();
    // tension less its part that answers to the unknown acceleration, which goes into the inertia
    const T tension = theta[0] * (q.dot(s.g_B.cast<T>()) - q.dot(w.cross(w.cross(r))) + theta[1] * bound(x));
    const V arm = r.cross(q);
    out.force_B += tension * q;
    out.torque_B += tension * arm;
    // friction of the joint: what it takes from the load across the cable, the vehicle gets, and the moment
    // that goes with it
    const V rub = theta[0] * theta[2] * theta[1] * (s.R_WB.transpose().cast<T>() * slip(s, x));
    const V reach = s.R_WB.transpose().cast<T>() * (theta[1] * Eigen::Map<const V>(x));
    out.force_B += rub;
    out.torque_B += (r + reach).cross(rub);
    Eigen::Matrix<T, 6, 1> line;
    line << q, arm;
    out.has_inertia = true;
    out.inertia += theta[0] * (line * line.transpose());
  }
  template <class T>
  void settle(const Situation& s, const T* theta, T* x) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const V> q(x), dq(x + 3);
    if (taut(x))
      x[6] = T(tension_per_mass(s, theta, x) < T(0) ? 0 : 1);
    else
      x[6] = T(q.squaredNorm() >= T(1) && q.dot(dq) > T(0) ? 1 : 0);
  }
  /// What a step as long as a recording's leaves of the constraint would be tension, and in a wide swing more
  /// than there is. A load that falls into the cable parts faster, and the spring catches it.
  template <class T>
  void restore_constraint(T* x) const {
    using V = Eigen::Matrix<T, 3, 1>;
    constexpr double kCaught = 0.5;  // 1/s
    Eigen::Map<V> q(x), dq(x + 3);
    const T parting = q.dot(dq);
    if (!taut(x) || parting > T(kCaught)) return;
    const V n = q.normalized();
    q = n;
    dq -= V(n.dot(dq) * n);
  }

 private:
  template <class T>
  static bool taut(const T* x) {
    return x[6] > T(0.5);
  }
  /// How the cable turns against the vehicle, across itself, world axes [1/s].
  template <class T>
  static Eigen::Matrix<T, 3, 1> slip(const Situation& s, const T* x) {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const V> q(x), dq(x + 3);
    const V n = q.normalized(), w = s.R_WB.cast<T>() * s.body.w_WB_B.cast<T>();
    return dq - n.dot(dq) * n - w.cross(V(q));
  }
  /// Gravity less the acceleration of the attachment, world axes [m/s^2].
  template <class T>
  static Eigen::Matrix<T, 3, 1> free_pull(const Situation& s, const T* theta) {
    using V = Eigen::Matrix<T, 3, 1>;
    const V r(theta[3], theta[4], theta[5]);
    const V w = s.body.w_WB_B.cast<T>();
    const V a_A =
        s.memory_acceleration().cast<T>() + s.memory_turn().cast<T>().cross(r) + w.cross(w.cross(r));
    return s.R_WB.cast<T>() * V(s.g_B.cast<T>() - a_A);
  }
  /// What keeps |q| = 1 [1/s^2]: the centripetal part, and a spring and damper that vanish on it. These catch
  /// a load that falls into the cable; load and vehicle feel the same.
  template <class T>
  static T bound(const T* x) {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const V> q(x), dq(x + 3);
    const T stretch = T(0.5) * (q.squaredNorm() - T(1)), parting = q.dot(dq);
    return dq.squaredNorm() + T(100) * parting + T(2500) * stretch;
  }
  /// Tension per mass of the load [m/s^2].
  template <class T>
  static T tension_per_mass(const Situation& s, const T* theta, const T* x) {
    const Eigen::Matrix<T, 3, 1> n = Eigen::Map<const Eigen::Matrix<T, 3, 1>>(x).normalized();
    return n.dot(free_pull(s, theta)) + theta[1] * bound(x);
  }
};

}  // namespace

const Effect& slung_load_effect() {
  static const SlungLoad effect;
  return effect;
}

}  // namespace omniflight::physics
