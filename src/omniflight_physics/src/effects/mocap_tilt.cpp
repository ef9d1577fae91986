// The world of the motion capture is not level.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class MocapTilt final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "mocap_tilt",
                                 .term = "motion capture world tilt",
                                 .equation = "p_m = R_d p",
                                 .latex = R"(p_m = R_d\,p)",
                                 .source = "definition",
                                 .parameters = {{"x", "d_x", "rad", -0.1, 0.1, 0.005, 0, true},
                                                {"y", "d_y", "rad", -0.1, 0.1, 0.005, 0, true}},
                                 .signals = {"position", "attitude", "acc"},
                                 .channels = {"Fx", "Fy", "Fz"},
                                 .stage = Stage::sensing,
                                 .aliases = {"wind", "constant_pull"},
                                 .separated_by = "a plumb line, or the accelerometer at rest",
                                 .words = {{"x", "y"}, [](const KnownValues& v) {
                                             return "the motion capture world is tilted by " +
                                                    in_degrees(std::hypot(v("x"), v("y")));
                                           }}};
    return info;
  }
  void alter_sensing(const double* theta, Sensing& s) const override {
    s.mocap_tilt += Vec3(theta[0], theta[1], 0);
  }
};

}  // namespace

const Effect& mocap_tilt_effect() {
  static const MocapTilt effect;
  return effect;
}

}  // namespace omniflight::physics
