// Drag of frame and payload, quadratic in speed.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class ParasiticDrag final : public WrenchEffect<ParasiticDrag> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "parasitic_drag",
                                 .term = "parasitic drag",
                                 .equation = "dF = -1/2 rho C_dA |v| v",
                                 .latex = R"(\Delta F = -\tfrac12 \rho\, C_dA\, |v|\, v)",
                                 .source = "standard drag equation",
                                 .parameters = {{"area", "C_dA", "m2", 0, 0.3, 0.01, 0, true}},
                                 .signals = {"velocity", "attitude"},
                                 .channels = {"Fx", "Fy", "Fz"},
                                 .stage = Stage::wrench,
                                 .aliases = {"rotor_drag", "wind"},
                                 .separated_by = "two speeds: linear against quadratic"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    out.force_B += theta[0] * (-0.5 * s.environment.air_density * s.v_WB_B.norm() * s.v_WB_B).cast<T>();
  }
};

}  // namespace

const Effect& parasitic_drag_effect() {
  static const ParasiticDrag effect;
  return effect;
}

}  // namespace omniflight::physics
