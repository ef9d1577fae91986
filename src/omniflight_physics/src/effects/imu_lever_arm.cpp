// The inertial sensor does not sit in the body origin.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class ImuLeverArm final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "imu_lever_arm",
        .term = "lever arm of the inertial sensor",
        .equation = "f_m = f + dw x r_I + w x (w x r_I)",
        .latex = R"(f_m = f + \dot\omega\times r_I + \omega\times(\omega\times r_I))",
        .source = "rigid-body kinematics; as in RotorPy",
        .parameters = {{"x", "r_Ix", "m", -0.3, 0.3, 0.02, 0, true},
                       {"y", "r_Iy", "m", -0.3, 0.3, 0.02, 0, true},
                       {"z", "r_Iz", "m", -0.3, 0.3, 0.02, 0, true}},
        .signals = {"acc", "gyro"},
        .channels = {"acc"},
        .stage = Stage::sensing,
        .aliases = {"com_offset", "accelerometer_error"},
        .separated_by = "rotation about each axis in place",
        .words = {{"x", "y", "z"}, [](const KnownValues& v) {
                    return "the inertial sensor sits " + along_body(v) + " of its place";
                  }}};
    return info;
  }

  void alter_sensing(const double* theta, Sensing& s) const override {
    s.imu_lever_arm += Vec3(theta[0], theta[1], theta[2]);
  }
};

}  // namespace

const Effect& imu_lever_arm_effect() {
  static const ImuLeverArm effect;
  return effect;
}

}  // namespace omniflight::physics
