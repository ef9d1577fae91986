// Thrust is not purely quadratic in speed.
#include "effects/table.hpp"
#include "effects/thrust_change.hpp"

namespace omniflight::physics {
namespace {

class ThrustCurve final : public WrenchEffect<ThrustCurve> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "thrust_curve",
        .term = "affine thrust curve",
        .equation = "T = c_2 Omega |Omega| + (c_1 |Omega| + c_0) Omega/sqrt(Omega^2 + 100)",
        .latex =
            R"(T = c_2\Omega|\Omega| + (c_1|\Omega|+c_0)\,\Omega/\sqrt{\Omega^2+\Omega_0^2},\ \Omega_0 = 10\,\mathrm{rad/s})",
        .source =
            "polynomial of degree two, exponents as fitted by Eschmann et al. 2024; smooth through zero",
        .parameters = {{"linear", "c_1", "N s/rad", -0.002, 0.002, 0.0003, 0, true},
                       {"constant", "c_0", "N", -0.5, 0.5, 0.1, 0, true}},
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "thrust_dead_zone"},
        .separated_by = "slow ramps of the speeds in the null space",
        .hidden_by_modelled_thrust =
            "it scales or shifts a thrust that is only modelled, for want of rotor speeds"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const double sign = r.speed / std::sqrt(r.speed * r.speed + 100.0);
      add_thrust(r, T(sign * std::abs(r.speed) * theta[0] + sign * theta[1]), out);
    }
  }
};

}  // namespace

const Effect& thrust_curve_effect() {
  static const ThrustCurve effect;
  return effect;
}

}  // namespace omniflight::physics
