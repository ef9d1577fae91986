// Thrust of every rotor depends on the tilt, by interference between the rotors.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class TiltEfficiency final : public WrenchEffect<TiltEfficiency> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "tilt_efficiency",
        .term = "tilt-dependent thrust efficiency",
        .equation = "T_i = eta(alpha) c_f Omega |Omega|, eta = eta_0 + eta_slope alpha",
        .latex = R"(T_i = (\eta_0 + \eta_1 \alpha)\, c_f \Omega_i |\Omega_i|)",
        .source =
            "thesis section 5.3: 34 % lost at 0 deg, 120 Hz, and a slope of 0.35 over 60 deg (its text may "
            "also be "
            "read as 0.35 left at 0 deg: loss 0.65)",
        .parameters = {{"loss", "1 - eta_0", "1", -0.2, 0.8, 0.34, 0, true},
                       {"recovery", "eta_1", "1/rad", -1.0, 1.0, 0.334, 0, true}},
        .signals = {"rotor_speed", "alpha"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "payload_mass"},
        .separated_by = "alpha sweep of at least 10 deg in hover",
        .hidden_by_modelled_thrust =
            "it scales or shifts a thrust that is only modelled, for want of rotor speeds",
        .words = {{"loss"}, [](const KnownValues& v) {
                    return in_percent(v("loss")) + by_sign(-v("loss"), " more", " less") +
                           " thrust than modelled, by the tilt of the rotors";
                  }}};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const T change = -theta[0] + theta[1] * T(s.alpha);
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 f = r.thrust * r.n_B;
      out.force_B += change * f.cast<T>();
      out.torque_B += change * (r.p_BR.cross(f) + r.spin * r.drag_ratio * f).cast<T>();
    }
  }
};

}  // namespace

const Effect& tilt_efficiency_effect() {
  static const TiltEfficiency effect;
  return effect;
}

}  // namespace omniflight::physics
