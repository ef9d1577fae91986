// A reversed propeller works with its trailing edge first.
#include "effects/table.hpp"
#include "effects/thrust_change.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class ReverseThrustAsymmetry final : public WrenchEffect<ReverseThrustAsymmetry> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "reverse_thrust_asymmetry",
        .term = "reverse thrust asymmetry",
        .equation = "T = c_f (1 + chi [Omega < 0]) Omega |Omega|",
        .latex = R"(T = c_f\,(1+\chi\,[\Omega<0])\,\Omega|\Omega|)",
        .source = "definition; measured on bidirectional rotors by Brescianini and D'Andrea 2018",
        .parameters = {{"change", "chi", "1", -0.9, 0.5, -0.2, 0, true}},
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_dead_zone", "tilt_efficiency", "rotor_thrust_scale"},
        .separated_by = "attitudes at which the signs of the thrusts change",
        .words = {{"change"}, [](const KnownValues& v) {
                    return "rotors in reverse give " + in_percent(v("change")) +
                           by_sign(v("change"), " more", " less") + " thrust than forward";
                  }}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors())
      if (r.thrust < 0) add_thrust(r, T(theta[0] * r.thrust), out);
  }
};

}  // namespace

const Effect& reverse_thrust_asymmetry_effect() {
  static const ReverseThrustAsymmetry effect;
  return effect;
}

}  // namespace omniflight::physics
