// A cable that hangs to the floor and swings in its first mode: the middle one of three fidelities.
#include "effects/lifting.hpp"
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class CablePendulum final : public MemoryEffect<CablePendulum, 4> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "cable_pendulum",
        .term = "hung cable with one pendulum mode",
        .equation =
            "dF = -R^T lambda [s (g + a_z) + max(v_z, 0)^2] e3 "
            "+ R^T [mu (wn^2 x + 2 zeta wn dx) - (lambda s - mu) a]_xy, d2x = -a_xy - 2 zeta wn dx - wn^2 x",
        .latex =
            R"(\Delta F_{xy} = \mu(\omega_1^2x+2\zeta\omega_1\dot x)-(\lambda s-\mu)a_{xy},\ \ddot x+2\zeta\omega_1\dot x+\omega_1^2x=-a_{xy},\ \omega_1=\tfrac{2.4048}{2}\sqrt{g/s},\ \mu=\tfrac{4}{2.4048^2}\lambda s)",
        .source =
            "first mode of a hanging chain (Bernoulli): frequency j_01/2 sqrt(g/s), modal mass 4/j_01^2 of "
            "the whole",
        .parameters = {{"linear_density", "lambda", "kg/m", 0, 1.5, 0.1, 0, true},
                       {"start_height", "h_0", "m", -1, 3, 0, 0, false},
                       {"length", "L", "m", 0.05, 10, 5, 5, false},
                       {"damping", "zeta", "1", 0, 1, 0.05, 0.05, false}},
        .signals = {"position", "velocity", "attitude", "acc"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"hung_cable", "slung_load"},
        .separated_by =
            "stop and wait at two heights: its frequency falls as one over the root of the hanging length",
        .words = {{"linear_density"}, [](const KnownValues& v) {
                    return "a swinging cable of " + hundredths(v("linear_density")) + " kg/m" +
                           from_height(v);
                  }}};
    return info;
  }

  // memory: displacement of the mode against the vehicle and its rate, world x and y
  template <class T>
  void start(const Situation&, const T*, T* x) const {
    for (int k = 0; k < 4; ++k) x[k] = T(0);
  }
  /// A mode that swings by a tenth of a metre, at its own frequency for a metre of cable.
  std::vector<double> start_spread(const double*) const override { return {0.1, 0.1, 0.4, 0.4}; }
  template <class T>
  void rate(const Situation& s, const T* theta, const T* x, T* dx) const {
    const Vec3 a = s.R_WB * s.memory_acceleration();
    const T square = squared_frequency(s, theta);
    using std::sqrt;
    for (int k = 0; k < 2; ++k) {
      dx[k] = x[k + 2];
      dx[k + 2] = T(-a[k]) - T(2) * theta[3] * sqrt(square) * x[k + 2] - square * x[k];
    }
  }
  template <class T>
  void wrench(const Situation& s, const T* theta, const T* x, WrenchT<T>& out) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const T hanging = length(s, theta);
    if (hanging <= T(0)) return;
    using std::sqrt;
    const T mass = theta[0] * hanging, mode = T(kModalShare) * mass, square = squared_frequency(s, theta);
    const T damping = T(2) * theta[3] * sqrt(square);
    const V f_W(mode * (square * x[0] + damping * x[2]), mode * (square * x[1] + damping * x[3]),
                hanging < theta[2] ? -picked_up(s, theta[0]) : T(0));
    out.force_B += mass * s.g_B.cast<T>() + s.R_WB.transpose().cast<T>() * f_W;
    const V rigid(mass - mode, mass - mode, mass);
    out.has_inertia = true;
    out.inertia.template topLeftCorner<3, 3>() +=
        s.R_WB.transpose().cast<T>() * rigid.asDiagonal() * s.R_WB.cast<T>();
  }

 private:
  static constexpr double kZero = 2.404825557695773;  // first zero of the Bessel function J0
  static constexpr double kModalShare = 4.0 / (kZero * kZero);
  template <class T>
  static T length(const Situation& s, const T* theta) {
    const T height = T(s.body.p_WB.z()) - theta[1];
    return height < T(0) ? T(0) : (height < theta[2] ? height : theta[2]);
  }
  template <class T>
  static T squared_frequency(const Situation& s, const T* theta) {
    const T hanging = length(s, theta);
    return T(0.25 * kZero * kZero * s.environment.gravity) / (hanging < T(0.05) ? T(0.05) : hanging);
  }
};

}  // namespace

const Effect& cable_pendulum_effect() {
  static const CablePendulum effect;
  return effect;
}

}  // namespace omniflight::physics
