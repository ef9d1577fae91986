// Voltage and current are reported wrongly.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class BatterySensorFault final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "battery_sensor_fault",
                                 .term = "battery sensor fault",
                                 .equation = "V_m = (1 + e_V) V + b_V, I_m = (1 + e_I) I",
                                 .latex = R"(V_m = (1+e_V)V+b_V,\quad I_m = (1+e_I)I)",
                                 .source = "definition",
                                 .parameters = {{"voltage_bias", "b_V", "V", -5, 5, 0.3, 0, true},
                                                {"voltage_scale", "e_V", "1", -0.5, 0.5, 0, 0, true},
                                                {"current_scale", "e_I", "1", -0.9, 1, 0.1, 0, true}},
                                 .signals = {"voltage", "current"},
                                 .channels = {"voltage", "current"},
                                 .stage = Stage::sensing,
                                 .aliases = {"battery_sag"},
                                 .separated_by = "a voltmeter at rest"};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.voltage_bias += theta[0];
    s.voltage_scale += theta[1];
    s.current_scale += theta[2];
  }
};

}  // namespace

const Effect& battery_sensor_fault_effect() {
  static const BatterySensorFault effect;
  return effect;
}

}  // namespace omniflight::physics
