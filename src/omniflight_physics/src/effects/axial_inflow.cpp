// Thrust falls with inflow along the axis.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class AxialInflow final : public WrenchEffect<AxialInflow> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "axial_inflow",
                                 .term = "axial inflow",
                                 .equation = "dF = -k_z sum |Omega_i| (n.v_i) n_i",
                                 .latex = R"(\Delta F = -k_z \sum_i |\Omega_i|\,(n_i\cdot v_i)\, n_i)",
                                 .source = "Leishman 2006; used by RotorPy",
                                 .parameters = {{"coefficient", "k_z", "kg/rad", 0, 0.002, 0.0002, 0, true}},
                                 .signals = {"rotor_speed", "velocity", "attitude"},
                                 .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
                                 .stage = Stage::wrench,
                                 .aliases = {"hung_cable", "vortex_ring"},
                                 .separated_by = "climb and descent at three speeds"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 v = s.v_WB_B + s.body.w_WB_B.cross(r.p_BR);
      out.add_at(r.p_BR, theta[0] * (-std::abs(r.speed) * r.n_B.dot(v) * r.n_B).cast<T>());
    }
  }
};

}  // namespace

const Effect& axial_inflow_effect() {
  static const AxialInflow effect;
  return effect;
}

}  // namespace omniflight::physics
