// The controller or allocator is set up for another vehicle, or a gain of it was cut.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class ControllerMismatch final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "controller_mismatch",
        .term = "controller and allocator mismatch",
        .equation = "w_c = diag(1 + g) w, T_c = T + A^+ (w_c - w)",
        .latex = R"(w_c = \mathrm{diag}(1+g)\,w,\quad T_c = T + A^{+}(w_c-w))",
        .source = "definition; thesis sections 4.3 and 8.1.3 (yaw gain cut)",
        .parameters = {{"force", "g_F", "1", -0.9, 1, 0, 0, false},
                       {"roll_pitch", "g_xy", "1", -0.9, 1, 0, 0, false},
                       {"yaw", "g_z", "1", -0.95, 1, -0.5, 0, false}},
        .signals = {"rotor_speed", "rotor_command"},
        .channels = {"rotor_speed"},
        .stage = Stage::control,
        .aliases = {"thrust_scale", "drag_torque_scale"},
        .separated_by = "replay of the recorded references and demands: no flight is needed",
        .also = {Stage::allocation, Stage::actuation},
        .words = {{}, [](const KnownValues&) { return std::string("the gains flown are not those told"); }}};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.wrench_gain.head<3>() *= 1.0 + theta[0];
    a.wrench_gain.segment<2>(3) *= 1.0 + theta[1];
    a.wrench_gain[5] *= 1.0 + theta[2];
  }
};

}  // namespace

const Effect& controller_mismatch_effect() {
  static const ControllerMismatch effect;
  return effect;
}

}  // namespace omniflight::physics
