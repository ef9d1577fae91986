// Unbalanced rotors shake the accelerometer, which rectifies part of it.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class Vibration final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "vibration",
        .term = "rotor imbalance and vibration rectification",
        .equation =
            "f_m = f + sum e_u Omega_i^2 (cos phi_i u_i + sin phi_i v_i) + r a_rms^2 e3, dphi_i/dt = Omega_i",
        .latex = R"(f_m = f + \sum_i e_u\Omega_i^2(\cos\varphi_i u_i+\sin\varphi_i v_i) + r\,a_{rms}^2 e_3)",
        .source =
            "centrifugal force of an unbalanced rotor, e_u = m_b e/m; rectification is quadratic in the "
            "vibration",
        .parameters = {{"imbalance", "e_u", "m", 0, 0.0001, 0.000002, 0, false},
                       {"rectification", "r", "s2/m", -0.1, 0.1, 0.01, 0, true}},
        .signals = {"acc", "rotor_speed"},
        .channels = {"acc"},
        .stage = Stage::sensing,
        .aliases = {"accelerometer_error", "command_quantisation"},
        .separated_by = "sweep of the rotor speeds in the null space"};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.imbalance += theta[0];
    s.rectification += theta[1];
  }
};

}  // namespace

const Effect& vibration_effect() {
  static const Vibration effect;
  return effect;
}

}  // namespace omniflight::physics
