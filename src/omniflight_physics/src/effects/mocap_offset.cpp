// The body of the motion capture system has another origin and other axes than the vehicle.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

std::string offset_of_the_body(const KnownValues& v) {
  std::string out;
  if (const double d = norm_of(v, "x", "y", "z"); d > 0) out = in_length(d);
  if (const double turn = norm_of(v, "roll", "pitch", "yaw"); turn > 0)
    out += (out.empty() ? "" : " and ") + in_degrees(turn);
  return "the motion capture body is off by " + out;
}

class MocapOffset final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "mocap_offset",
                                 .term = "motion capture body offset and misalignment",
                                 .equation = "p_m = p + R d, R_m = R exp([e]x)",
                                 .latex = R"(p_m = p + R\,d,\quad R_m = R\exp([e]_\times))",
                                 .source = "rigid-body kinematics",
                                 .parameters = {{"x", "d_x", "m", -0.2, 0.2, 0.01, 0, true},
                                                {"y", "d_y", "m", -0.2, 0.2, 0.01, 0, true},
                                                {"z", "d_z", "m", -0.2, 0.2, 0.01, 0, true},
                                                {"roll", "e_x", "rad", -0.2, 0.2, 0.01, 0, true},
                                                {"pitch", "e_y", "rad", -0.2, 0.2, 0.01, 0, true},
                                                {"yaw", "e_z", "rad", -0.2, 0.2, 0.01, 0, true}},
                                 .signals = {"position", "attitude", "gyro"},
                                 .channels = {"position", "attitude"},
                                 .stage = Stage::sensing,
                                 .aliases = {"com_offset", "gyro_error", "imu_lever_arm"},
                                 .separated_by = "pure rotations in place",
                                 .words = {{"x", "y", "z", "roll", "pitch", "yaw"}, offset_of_the_body}};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.mocap_offset += Vec3(theta[0], theta[1], theta[2]);
    s.mocap_misalignment += Vec3(theta[3], theta[4], theta[5]);
  }
};

}  // namespace

const Effect& mocap_offset_effect() {
  static const MocapOffset effect;
  return effect;
}

}  // namespace omniflight::physics
