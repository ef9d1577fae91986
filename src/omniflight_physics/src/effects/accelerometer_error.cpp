// Bias of the accelerometer.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class AccelerometerError final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "accelerometer_error",
                                 .term = "accelerometer bias",
                                 .equation = "f_m = f + b",
                                 .latex = R"(f_m = f + b)",
                                 .source = "definition",
                                 .parameters = {{"bias_x", "b_x", "m/s2", -3, 3, 0.05, 0, true},
                                                {"bias_y", "b_y", "m/s2", -3, 3, 0.05, 0, true},
                                                {"bias_z", "b_z", "m/s2", -3, 3, 0.05, 0, true}},
                                 .signals = {"acc"},
                                 .channels = {"acc"},
                                 .stage = Stage::sensing,
                                 .aliases = {"payload_mass", "constant_pull", "com_offset"},
                                 .separated_by = "six rest positions; compare with motion capture",
                                 .words = {{"bias_x", "bias_y", "bias_z"}, [](const KnownValues& v) {
                                             return "the accelerometer is off by " +
                                                    two_digits(norm_of(v, "bias_x", "bias_y", "bias_z")) +
                                                    " m/s2";
                                           }}};
    return info;
  }
  void alter_sensing(const double* theta, Sensing& s) const override {
    s.accelerometer_bias += Vec3(theta[0], theta[1], theta[2]);
  }
};

}  // namespace

const Effect& accelerometer_error_effect() {
  static const AccelerometerError effect;
  return effect;
}

}  // namespace omniflight::physics
