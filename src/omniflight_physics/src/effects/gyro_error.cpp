// Bias of the gyroscope.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class GyroError final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "gyro_error",
        .term = "gyroscope bias",
        .equation = "w_m = w + b",
        .latex = R"(\omega_m = \omega + b)",
        .source = "definition",
        .parameters = {{"bias_x", "b_x", "rad/s", -1, 1, 0.01, 0, true},
                       {"bias_y", "b_y", "rad/s", -1, 1, 0.01, 0, true},
                       {"bias_z", "b_z", "rad/s", -1, 1, 0.01, 0, true}},
        .signals = {"gyro", "attitude"},
        .channels = {"gyro"},
        .stage = Stage::sensing,
        .aliases = {"clock_offset"},
        .separated_by = "rest",
        .words = {{"bias_x", "bias_y", "bias_z"}, [](const KnownValues& v) {
                    return "the gyroscope is off by " +
                           two_digits(to_degrees(norm_of(v, "bias_x", "bias_y", "bias_z"))) + " deg/s";
                  }}};
    return info;
  }
  void alter_sensing(const double* theta, Sensing& s) const override {
    s.gyro_bias += Vec3(theta[0], theta[1], theta[2]);
  }
};

}  // namespace

const Effect& gyro_error_effect() {
  static const GyroError effect;
  return effect;
}

}  // namespace omniflight::physics
