// Mass at the body origin that the model does not know.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class PayloadMass final : public WrenchEffect<PayloadMass> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "payload_mass",
        .term = "payload mass",
        .equation = "dF = -dm (a + g e3)",
        .latex = R"(\Delta F = -\Delta m\,(a + g e_3))",
        .source = "Newton, Euler; Ho et al. 2017 for its estimation in closed loop",
        .parameters = {{"mass", "dm", "kg", -0.5, 2.0, 0.1, 0, true}},
        .signals = {"attitude", "acc"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "constant_pull", "hung_cable", "tilt_efficiency"},
        .separated_by = "vertical and lateral accelerations at constant tilt; weighing the vehicle",
        .hidden_by_modelled_thrust =
            "it scales or shifts a thrust that is only modelled, for want of rotor speeds",
        .words = {{"mass"}, [](const KnownValues& v) {
                    return in_mass(v("mass")) + by_sign(v("mass"), " too heavy", " too light");
                  }}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    out.force_B += theta[0] * s.g_B.cast<T>();
    out.mass += theta[0];
  }
};

}  // namespace

const Effect& payload_mass_effect() {
  static const PayloadMass effect;
  return effect;
}

}  // namespace omniflight::physics
