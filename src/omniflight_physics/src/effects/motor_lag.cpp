// The rotors follow their command later than the model says, or sooner: another time constant.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class MotorLag final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "motor_lag",
        .term = "motor first-order lag",
        .equation = "dOmega = (Omega_c - Omega)/(tau + tau_m)",
        .latex = R"(\dot\Omega = (\Omega_c-\Omega)/(\tau+\tau_m))",
        .source = "first-order motor model",
        .parameters = {{"time_constant", "tau_m", "s", -0.5, 0.5, 0.03, 0, true}},
        .signals = {"rotor_speed", "rotor_command"},
        .channels = {"rotor_speed"},
        .stage = Stage::actuation,
        .aliases = {"transport_delay", "dynamic_inflow"},
        .separated_by = "pseudo-random command steps: a lag rolls the gain off, a delay does not",
        .words = {{"time_constant"}, [](const KnownValues& v) {
                    return "motors " + two_digits(1e3 * std::abs(v("time_constant"))) + " ms " +
                           by_sign(v("time_constant"), "slower", "faster") + " than modelled";
                  }}};
    return info;
  }
  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    for (double& tau : a.time_constant) tau += theta[0];
  }
};

}  // namespace

const Effect& motor_lag_effect() {
  static const MotorLag effect;
  return effect;
}

}  // namespace omniflight::physics
