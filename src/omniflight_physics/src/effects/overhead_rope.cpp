// A slack rope from an anchor above: its loop hangs down, and the vehicle carries its own side of the loop.
#include <fmt/format.h>

#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class OverheadRope final : public WrenchEffect<OverheadRope> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "overhead_rope",
        .term = "slack overhead rope",
        .equation = "s = (L - (H - h))/2 within [0, L], dF = -R^T [lambda s (g + a_z) + lambda v_z^2/4] e3",
        .latex =
            R"(\Delta F = -R^T\big[\lambda s\,(g+\ddot z) + \tfrac14\lambda\dot z^2\big]e_3,\quad s = \tfrac12\big(L-(H-h)\big))",
        .source =
            "folded chain by Lagrange's equation: kinetic energy lambda s v^2/2, weight lambda s g, ds/dh "
            "= 1/2; anchor straight above",
        .parameters = {{"linear_density", "lambda", "kg/m", 0, 0.5, 0.05, 0, true},
                       {"anchor_height", "H", "m", 0.3, 20, 3.2, 3.2, false},
                       {"length", "L", "m", 0.1, 30, 3.5, 3.5, false}},
        .signals = {"position", "velocity", "attitude", "acc"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"hung_cable", "constant_pull", "payload_mass"},
        .separated_by =
            "another anchor height or rope length; its slope with height is half that of a hung cable",
        .words = {{"linear_density"}, [](const KnownValues& v) {
                    return "a rope from above of " + hundredths(v("linear_density")) + " kg/m";
                  }}};
    return info;
  }

  Status check_feasible(const vehicle::Vehicle&, const RigidState& initial,
                        const double* theta) const override {
    const double anchor = theta[1], length = theta[2], height = initial.p_WB.z();
    if (length >= anchor - height) return {};
    return bad_input(
        fmt::format("is {:g} m, shorter than the {:g} m from the vehicle at {:g} m up to the anchor "
                    "(anchor_height {:g} m)",
                    length, anchor - height, height, anchor),
        parameter_field(2), "Lengthen the rope, lower the anchor or start higher");
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    T side = T(0.5) * (theta[2] - theta[1] + T(s.body.p_WB.z()));
    if (side <= T(0)) return;  // taut
    const bool whole = side >= theta[2];
    if (whole) side = theta[2];  // level with the anchor or above it
    const Vec3 up = s.R_WB.row(2).transpose();
    const double climb = s.body.v_WB_W.z();
    out.force_B += theta[0] * side * s.g_B.cast<T>();
    if (!whole) out.force_B -= theta[0] * T(0.25 * climb * climb) * up.cast<T>();
    out.lifted_mass += theta[0] * side;
  }
};

}  // namespace

const Effect& overhead_rope_effect() {
  static const OverheadRope effect;
  return effect;
}

}  // namespace omniflight::physics
