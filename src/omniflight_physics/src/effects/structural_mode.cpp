// The frame between the body and the inertial sensor is a spring.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class StructuralMode final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "structural_mode",
        .term = "structural mode",
        .equation = "y = u + p (G u - u), G = wn^2/(s^2 + 2 z wn s + wn^2)",
        .latex = R"(y = u + p\,(G u-u),\quad G = \frac{\omega_n^2}{s^2+2\zeta\omega_n s+\omega_n^2})",
        .source = "one mode of a flexible structure",
        .parameters = {{"participation", "p", "1", 0, 1, 0.5, 0, true},
                       {"frequency", "f_n", "Hz", 2, 100, 20, 20, false},
                       {"damping", "zeta", "1", 0.005, 0.5, 0.05, 0.05, false}},
        .signals = {"acc", "gyro"},
        .channels = {"acc", "gyro"},
        .stage = Stage::sensing,
        .aliases = {"transport_delay", "sensor_filter"},
        .separated_by = "a chirp; compare inertial sensor and motion capture",
        .one_value = {"frequency", "damping"}};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.mode_participation += theta[0];
    if (theta[0] == 0) return;
    s.mode_frequency = theta[1];
    s.mode_damping = theta[2];
  }
};

}  // namespace

const Effect& structural_mode_effect() {
  static const StructuralMode effect;
  return effect;
}

}  // namespace omniflight::physics
