// The rotors reach less thrust than the limits say, and change their speed no faster than the driver lets
// them.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class ActuatorSaturation final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "actuator_saturation",
                                 .term = "saturation and slew limit",
                                 .equation = "|Omega| <= Omega_max sqrt(1 - l), |dOmega/dt| <= a",
                                 .latex = R"(|\Omega|\le\Omega_{max}\sqrt{1-l},\quad |\dot\Omega|\le a)",
                                 .source = "definition; thesis Table 4.1 for the limit",
                                 .parameters = {{"limit_loss", "l", "1", 0, 0.95, 0.3, 0, false},
                                                {"slew", "a", "rad/s2", 50, 1000000, 4000, 1000000, false}},
                                 .signals = {"rotor_speed", "rotor_command"},
                                 .channels = {"rotor_speed"},
                                 .stage = Stage::actuation,
                                 .aliases = {"battery_sag", "motor_lag", "thrust_dead_zone"},
                                 .separated_by = "a step to the limit: look at the active set only",
                                 .words = {{"limit_loss"}, [](const KnownValues& v) {
                                             return "the largest thrust is " + in_percent(v("limit_loss")) +
                                                    " less than modelled";
                                           }}};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.speed_limit_scale *= std::sqrt(1.0 - theta[0]);
    if (theta[1] < info().parameters[1].upper) a.slew_limit = std::min(a.slew_limit, theta[1]);
  }
};

}  // namespace

const Effect& actuator_saturation_effect() {
  static const ActuatorSaturation effect;
  return effect;
}

}  // namespace omniflight::physics
