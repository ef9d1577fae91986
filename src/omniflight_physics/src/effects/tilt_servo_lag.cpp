// The tilt follows its command late and with play.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class TiltServoLag final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "tilt_servo_lag",
        .term = "tilt servo lag and backlash",
        .equation = "d alpha_s/dt = (alpha_c - alpha_s)/tau_a, |alpha - alpha_s| <= b/2",
        .latex = R"(\dot\alpha_s = (\alpha_c-\alpha_s)/\tau_a,\quad |\alpha-\alpha_s|\le b/2)",
        .source = "first-order servo and the play operator",
        .parameters = {{"time_constant", "tau_a", "s", 0, 2, 0.15, 0, false},
                       {"backlash", "b", "rad", 0, 0.2, 0.02, 0, false}},
        .signals = {"alpha", "alpha_command"},
        .channels = {"alpha"},
        .stage = Stage::actuation,
        .aliases = {"tilt_offset", "tilt_efficiency"},
        .separated_by = "steps of the tilt in hover, up and down"};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.tilt_time_constant += theta[0];
    a.tilt_backlash += theta[1];
  }
};

}  // namespace

const Effect& tilt_servo_lag_effect() {
  static const TiltServoLag effect;
  return effect;
}

}  // namespace omniflight::physics
