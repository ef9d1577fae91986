// The reaction torque of the rotors differs from its coefficient.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class DragTorqueScale final : public WrenchEffect<DragTorqueScale> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "drag_torque_scale",
        .term = "rotor drag torque error",
        .equation = "dM = eps_k sum kappa s_i T_i n_i",
        .latex = R"(\Delta\tau = \varepsilon_\kappa \sum_i \kappa s_i T_i n_i)",
        .source = "definition",
        .parameters = {{"scale", "eps_kappa", "1", -0.9, 2.0, 0.2, 0, true}},
        .signals = {"rotor_speed"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"inertia_error", "cable_torsion"},
        .separated_by = "yaw steps at several tilts",
        .words = {{"scale"}, [](const KnownValues& v) {
                    return "the drag torque of the rotors is " + in_percent(v("scale")) +
                           by_sign(v("scale"), " larger", " smaller") + " than modelled";
                  }}};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors())
      out.torque_B += theta[0] * (r.spin * r.drag_ratio * r.thrust * r.n_B).cast<T>();
  }

  double shaft_power(const Situation& s, const double* theta) const override {
    double power = 0;
    for (const RotorSituation& r : s.all_rotors())
      power += theta[0] * std::abs(r.drag_ratio * r.thrust * r.speed);
    return power;
  }
};

}  // namespace

const Effect& drag_torque_scale_effect() {
  static const DragTorqueScale effect;
  return effect;
}

}  // namespace omniflight::physics
