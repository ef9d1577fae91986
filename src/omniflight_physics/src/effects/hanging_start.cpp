// The flight starts in a rope that carries the vehicle until it has risen.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class HangingStart final : public WrenchEffect<HangingStart> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "hanging_start",
        .term = "hanging start",
        .equation = "dF = R^T k [h_s - z - tau dz/dt]_+ e3 where z < h_s",
        .latex = R"(\Delta F = R^T k\,[h_s - z - \tau\dot z]_+\,e_3\quad (z<h_s))",
        .source = "unilateral spring and damper; thesis section 9.1.3",
        .parameters = {{"stiffness", "k", "N/m", 0, 5000, 100, 0, true},
                       {"height", "h_s", "m", -2, 10, 1, 1, false},
                       {"damping_time", "tau", "s", 0, 1, 0.05, 0.05, false}},
        .signals = {"position", "velocity", "attitude"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"taut_rope", "constant_pull", "ground_effect"},
        .separated_by = "leave the first seconds out: above its height it is nothing"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const T below = theta[1] - T(s.body.p_WB.z());
    if (below <= T(0)) return;
    const T stretch = below - theta[2] * T(s.body.v_WB_W.z());
    if (stretch <= T(0)) return;
    out.force_B += theta[0] * stretch * s.R_WB.row(2).transpose().cast<T>();
  }
};

}  // namespace

const Effect& hanging_start_effect() {
  static const HangingStart effect;
  return effect;
}

}  // namespace omniflight::physics
