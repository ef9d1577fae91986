// The clock of the motion capture runs beside that of the inertial sensor.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

std::string late_or_drifting(const KnownValues& v) {
  const double offset = v("offset");
  if (offset != 0)
    return "motion capture stamps " + two_digits(1e3 * std::abs(offset)) + " ms too " +
           by_sign(offset, "late", "early");
  return "the motion capture clock drifts by " + two_digits(1e6 * v("skew")) + " ppm";
}

class ClockOffset final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "clock_offset",
        .term = "clock offset and skew",
        .equation = "x_m(t) = x((1 + eps) t + t_d)",
        .latex = R"(x_m(t) = x((1+\epsilon)\,t + t_d))",
        .source = "definition",
        .parameters = {{"offset", "t_d", "s", -0.2, 0.2, 0.01, 0, true},
                       {"skew", "eps", "1", -0.001, 0.001, 0.00005, 0, true}},
        .signals = {"position", "attitude", "gyro"},
        .channels = {"stamp"},
        .stage = Stage::sensing,
        .aliases = {"motor_lag", "transport_delay", "sensor_filter"},
        .separated_by =
            "correlate gyro and motion-capture rate window by window: the slope of the lag is the skew",
        .words = {{"offset", "skew"}, late_or_drifting}};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.mocap_clock_offset += theta[0];
    s.mocap_clock_skew += theta[1];
  }
};

}  // namespace

const Effect& clock_offset_effect() {
  static const ClockOffset effect;
  return effect;
}

}  // namespace omniflight::physics
