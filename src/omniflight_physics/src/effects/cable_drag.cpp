// Air drag of a hung cable that the vehicle drags along by its upper end.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class CableDrag final : public WrenchEffect<CableDrag> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "cable_drag",
        .term = "cable drag",
        .equation = "s = clamp(h - h0, 0, L), dF = -1/8 rho C_D d s R^T |v_xy| v_xy",
        .latex =
            R"(\Delta F = -\tfrac18\rho\,C_Dd\,s\,R^T|v_{xy}|v_{xy},\quad s = \mathrm{clamp}(h-h_0,0,L))",
        .source =
            "cross-flow drag of a vertical cylinder, speed growing from zero at the floor to v at the "
            "vehicle, moments about the floor point: integral of xi^3 gives 1/4 of the full drag",
        .parameters = {{"width", "C_D d", "m", 0, 0.1, 0.006, 0, true},
                       {"start_height", "h_0", "m", -1, 3, 0, 0, false},
                       {"length", "L", "m", 0.05, 10, 5, 5, false}},
        .signals = {"position", "velocity", "attitude"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"parasitic_drag", "rotor_drag"},
        .separated_by = "the same speed at two heights, and without the cable"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    T length = T(s.body.p_WB.z()) - theta[1];
    if (length <= T(0)) return;
    if (length > theta[2]) length = theta[2];
    Vec3 v = s.body.v_WB_W;
    v.z() = 0;
    const Vec3 f = s.R_WB.transpose() * (-0.125 * s.environment.air_density * v.norm() * v);
    out.force_B += theta[0] * length * f.cast<T>();
  }
};

}  // namespace

const Effect& cable_drag_effect() {
  static const CableDrag effect;
  return effect;
}

}  // namespace omniflight::physics
