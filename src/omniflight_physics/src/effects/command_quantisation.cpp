// Commands arrive at a finite rate and in steps.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class CommandQuantisation final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "command_quantisation",
                                 .term = "command rate and quantisation",
                                 .equation = "Omega_c = q round(Omega_c(t_k)/q), t_k = k T_c",
                                 .latex = R"(\Omega_c = q\,\mathrm{round}(\Omega_c(kT_c)/q))",
                                 .source = "definition: zero-order hold and uniform quantiser",
                                 .parameters = {{"period", "T_c", "s", 0, 0.1, 0.01, 0, false},
                                                {"step", "q", "rad/s", 0, 100, 6.28, 0, false}},
                                 .signals = {"rotor_speed", "rotor_command"},
                                 .channels = {"rotor_speed"},
                                 .stage = Stage::actuation,
                                 .aliases = {"transport_delay", "vibration"},
                                 .separated_by = "compare the staircase of commands with telemetry"};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.command_period = std::max(a.command_period, theta[0]);
    a.command_step = std::max(a.command_step, theta[1]);
  }
};

}  // namespace

const Effect& command_quantisation_effect() {
  static const CommandQuantisation effect;
  return effect;
}

}  // namespace omniflight::physics
