// Slow commands stop a rotor, and a rotor rests before it turns the other way.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class ThrustDeadZone final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "thrust_dead_zone",
        .term = "dead zone and dwell at reversal",
        .equation = "Omega_c = 0 where |Omega_c| < Omega_min; Omega_c = 0 for t_rev after a change of sign",
        .latex =
            R"(\Omega_c = 0\ \text{where}\ |\Omega_c|<\Omega_{min};\ \text{rest of}\ t_{rev}\ \text{at a change of sign})",
        .source = "definition; smallest thrust 0.15 N in thesis Table 4.1 is 178 rad/s",
        .parameters = {{"dead_speed", "Omega_min", "rad/s", 0, 600, 178, 0, false},
                       {"dwell", "t_rev", "s", 0, 0.5, 0.05, 0, false}},
        .signals = {"rotor_speed", "rotor_command"},
        .channels = {"rotor_speed"},
        .stage = Stage::actuation,
        .aliases = {"actuator_saturation", "command_quantisation", "reverse_thrust_asymmetry"},
        .separated_by = "slow crossing of zero by one rotor after the other"};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.dead_speed = std::max(a.dead_speed, theta[0]);
    a.reversal_dwell += theta[1];
  }
};

}  // namespace

const Effect& thrust_dead_zone_effect() {
  static const ThrustDeadZone effect;
  return effect;
}

}  // namespace omniflight::physics
