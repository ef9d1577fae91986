// Spinning rotors carry angular momentum that the model leaves out.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class RotorInertia final : public WrenchEffect<RotorInertia> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "rotor_inertia",
        .term = "rotor gyroscopic and spin-up torque",
        .equation = "dM = sum J_r s_i (dOmega_i n_i + w x Omega_i n_i)",
        .latex = R"(\Delta\tau = \sum_i J_r s_i\,(\dot\Omega_i n_i + \omega \times \Omega_i n_i))",
        .source = "angular momentum balance; sign: a rotor with spin +1 turns against the torque it exerts",
        .parameters = {{"inertia", "J_r", "kg m2", 0, 0.001, 2e-05, 0, true}},
        .signals = {"rotor_speed", "gyro"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"inertia_error", "drag_torque_scale"},
        .separated_by = "fast yaw steps; rotor speed changes in the null space"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    // spin +1 exerts +drag torque on the body, hence turns about -n; its momentum is -s J_r Omega n.
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 rate = r.acceleration * r.n_B + s.body.w_WB_B.cross(r.speed * r.n_B);
      out.torque_B += theta[0] * (r.spin * rate).cast<T>();
    }
  }
};

}  // namespace

const Effect& rotor_inertia_effect() {
  static const RotorInertia effect;
  return effect;
}

}  // namespace omniflight::physics
