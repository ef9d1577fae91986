// Drag of the blades against motion in the disc plane, proportional to rotor speed.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class RotorDrag final : public WrenchEffect<RotorDrag> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "rotor_drag",
                                 .term = "rotor drag (H-force)",
                                 .equation = "dF = -sum |Omega_i| k_d (I - n n^T) v_i, v_i = R^T v + w x r_i",
                                 .latex = R"(\Delta F = -\sum_i |\Omega_i|\, k_d\,(I - n_i n_i^T)\, v_i)",
                                 .source = "Martin and Salaun 2010; used by RotorPy and PX4",
                                 .parameters = {{"coefficient", "k_d", "kg/rad", 0, 0.001, 0.0001, 0, true}},
                                 .signals = {"rotor_speed", "velocity", "attitude"},
                                 .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
                                 .stage = Stage::wrench,
                                 .aliases = {"parasitic_drag", "wind", "lateral_stiffness"},
                                 .separated_by = "constant speed both ways at two rotor-speed levels"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 v = s.v_WB_B + s.body.w_WB_B.cross(r.p_BR);
      const Vec3 in_plane = v - r.n_B.dot(v) * r.n_B;
      out.add_at(r.p_BR, theta[0] * (-std::abs(r.speed) * in_plane).cast<T>());
    }
  }
};

}  // namespace

const Effect& rotor_drag_effect() {
  static const RotorDrag effect;
  return effect;
}

}  // namespace omniflight::physics
