// Every rotor gives more or less thrust than its coefficient says.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class ThrustScale final : public WrenchEffect<ThrustScale> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "thrust_scale",
        .term = "thrust coefficient error",
        .equation = "dF = eps sum T_i n_i, dM likewise",
        .latex = R"(\Delta F = \varepsilon \sum_i T_i n_i)",
        .source = "definition; includes air density",
        .parameters = {{"scale", "eps", "1", -0.7, 0.7, -0.1, 0, true}},
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"payload_mass", "tilt_efficiency", "constant_pull", "ground_effect"},
        .separated_by = "angular accelerations with known inertia; a known test mass",
        .hidden_by_modelled_thrust =
            "it scales or shifts a thrust that is only modelled, for want of rotor speeds",
        .words = {{"scale"}, [](const KnownValues& v) {
                    return "the rotors give " + in_percent(v("scale")) +
                           by_sign(v("scale"), " more", " less") + " thrust than modelled";
                  }}};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 f = r.thrust * r.n_B;
      out.force_B += theta[0] * f.cast<T>();
      out.torque_B += theta[0] * (r.p_BR.cross(f) + r.spin * r.drag_ratio * f).cast<T>();
    }
  }
};

}  // namespace

const Effect& thrust_scale_effect() {
  static const ThrustScale effect;
  return effect;
}

}  // namespace omniflight::physics
