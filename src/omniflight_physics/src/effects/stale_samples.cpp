// Old values arrive under new stamps.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class StaleSamples final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "stale_samples",
                                 .term = "stale samples",
                                 .equation = "x_m(t_k) = x_m(t_(k-1)) with probability P",
                                 .latex = R"(x_m(t_k) = x_m(t_{k-1})\ \text{with probability}\ P)",
                                 .source = "definition",
                                 .parameters = {{"mocap", "P_m", "1", 0, 0.95, 0.2, 0, false},
                                                {"imu", "P_i", "1", 0, 0.95, 0.05, 0, false}},
                                 .signals = {"position", "attitude", "acc", "gyro"},
                                 .channels = {"position", "attitude", "acc", "gyro"},
                                 .stage = Stage::sensing,
                                 .aliases = {"transport_delay"},
                                 .separated_by = "sequence numbers and repeated values"};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.stale_mocap = 1.0 - (1.0 - s.stale_mocap) * (1.0 - theta[0]);
    s.stale_imu = 1.0 - (1.0 - s.stale_imu) * (1.0 - theta[1]);
  }
};

}  // namespace

const Effect& stale_samples_effect() {
  static const StaleSamples effect;
  return effect;
}

}  // namespace omniflight::physics
