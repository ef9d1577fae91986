// Moment of the discs in forward motion: the advancing side lifts more, the disc tilts back, the nose rises.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class BladeFlapping final : public WrenchEffect<BladeFlapping> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "blade_flapping",
        .term = "blade flapping moment",
        .equation = "dM = sum k_f |Omega_i| (v_i x n_i)",
        .latex = R"(\Delta\tau = \sum_i k_f |\Omega_i|\,(v_i\times n_i))",
        .source = "Mahony, Kumar and Corke 2012; used by RotorPy and PX4",
        .parameters = {{"coefficient", "k_f", "kg m/rad", 0, 0.0001, 1e-06, 0, true}},
        .signals = {"rotor_speed", "velocity", "attitude"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"com_offset", "rotor_drag"},
        .separated_by = "constant speed at two attitudes"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const Vec3 v = s.v_WB_B + s.body.w_WB_B.cross(r.p_BR);
      out.torque_B += theta[0] * (std::abs(r.speed) * v.cross(r.n_B)).cast<T>();
    }
  }
};

}  // namespace

const Effect& blade_flapping_effect() {
  static const BladeFlapping effect;
  return effect;
}

}  // namespace omniflight::physics
