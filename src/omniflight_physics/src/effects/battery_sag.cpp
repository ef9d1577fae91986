// The voltage of the battery falls with load and with the energy drawn, and the speeds with it.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class BatterySag final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "battery_sag",
        .term = "battery voltage sag",
        .equation = "V = V_0 - k_E E - R I, Omega_max ~ V, open loop: Omega ~ V/V_0",
        .latex = R"(V = V_0 - k_E E - R I,\quad \Omega = \Omega_c\,V/V_0)",
        .source = "equivalent circuit with one resistance; open-loop speed control",
        .parameters = {{"resistance", "R", "ohm", 0, 1, 0.03, 0, false},
                       {"drop", "k_E", "V/J", 0, 0.01, 0.00002, 0, false},
                       {"voltage", "V_0", "V", 3, 60, 16.8, 16.8, false},
                       {"open_loop", "o", "1", 0, 1, 1, 1, false}},
        .signals = {"rotor_speed", "rotor_command", "voltage"},
        .channels = {"rotor_speed", "voltage"},
        .stage = Stage::actuation,
        .aliases = {"thrust_scale", "actuator_saturation"},
        .separated_by = "the same hover at the start and at the end; log of the voltage",
        .also = {Stage::sensing, Stage::power},
        .one_value = {"voltage", "open_loop"}};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.battery_resistance += theta[0];
    a.battery_drop += theta[1];
    if (theta[0] == 0 && theta[1] == 0) return;
    a.battery_voltage = theta[2];
    a.open_loop = theta[3];
  }
  void alter_sensing(const double* theta, Sensing& s) const override {
    s.battery_resistance += theta[0];
    s.battery_drop += theta[1];
  }
};

}  // namespace

const Effect& battery_sag_effect() {
  static const BatterySag effect;
  return effect;
}

}  // namespace omniflight::physics
