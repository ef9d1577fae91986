// The inertial sensor filters before it reports.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class SensorFilter final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "sensor_filter",
        .term = "low-pass filter of the inertial sensor",
        .equation = "y = wc^2/(s^2 + 2 z wc s + wc^2) u, wc = 1/T",
        .latex = R"(y = \frac{\omega_c^2}{s^2+2\zeta\omega_c s+\omega_c^2}\,u,\quad \omega_c = 1/T)",
        .source = "second-order low-pass; f_c = 1/(2 pi T), 30 Hz is 5.3 ms",
        .parameters = {{"gyro_time", "T_g", "s", 0, 0.1, 0.005, 0, false},
                       {"accelerometer_time", "T_a", "s", 0, 0.1, 0.005, 0, false},
                       {"damping", "zeta", "1", 0.3, 2, 0.7071067811865476, 0.7071067811865476, false}},
        .signals = {"acc", "gyro"},
        .channels = {"acc", "gyro"},
        .stage = Stage::sensing,
        .aliases = {"clock_offset", "structural_mode"},
        .separated_by = "a chirp in each axis",
        .one_value = {"damping"}};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.gyro_filter_time += theta[0];
    s.accelerometer_filter_time += theta[1];
    if (theta[0] > 0 || theta[1] > 0) s.filter_damping = theta[2];
  }
};

}  // namespace

const Effect& sensor_filter_effect() {
  static const SensorFilter effect;
  return effect;
}

}  // namespace omniflight::physics
