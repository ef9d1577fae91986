// A cable that hangs from the vehicle to the floor: its carried weight grows with height.
#include <algorithm>
#include <cmath>

#include "effects/lifting.hpp"
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class HungCable final : public WrenchEffect<HungCable> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "hung_cable",
        .term = "hung cable, altitude-dependent weight",
        .equation =
            "s = clamp(h - h0, 0, L), dF = -R^T lambda [s (g + a_z) + max(v_z, 0)^2] e3, "
            "the last where 0 < s < L",
        .latex =
            R"(\Delta F = -R^T \lambda\big[s\,(g + \ddot z) + \max(\dot z,0)^2\big] e_3,\quad s = \mathrm{clamp}(h-h_0, 0, L))",
        .source =
            "thesis section 8.1; quasi-static, inertia of the carried length, momentum of what is lifted off "
            "the floor (what is laid down gives none back), checked against an articulated chain",
        .parameters = {{"linear_density", "lambda", "kg/m", 0, 1.5, 0.1, 0, true},
                       {"start_height", "h_0", "m", -1.0, 3.0, 0.0, 0.0, false},
                       {"length", "L", "m", 0.05, 10, 5, 5, false}},
        .signals = {"position", "velocity", "attitude", "acc"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"constant_pull", "payload_mass", "overhead_rope", "ground_effect"},
        .separated_by = "ascent and descent over 0.7 m or more, with pauses",
        .words = {{"linear_density"}, [](const KnownValues& v) {
                    return "a cable of " + hundredths(v("linear_density")) + " kg/m" + from_height(v);
                  }}};
    return info;
  }

  /// Cables that begin below the flight or at the quarters of its range of heights, and hang free from the
  /// next of these on or never: between them the weight grows, and it has a kink at both.
  std::vector<std::vector<double>> telling_shapes(std::span<const Situation> motion) const override {
    std::vector<std::vector<double>> out;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Situation& s : motion) {
      low = std::min(low, s.body.p_WB.z());
      high = std::max(high, s.body.p_WB.z());
    }
    const Parameter &start = info().parameters[1], &length = info().parameters[2];
    for (const double begin : {-1.0, -0.25, 0.25, 0.5, 0.75})
      for (const double end : {0.25, 0.5, 0.75, HUGE_VAL}) {
        if (motion.empty() || end <= begin) continue;
        out.push_back({0, std::clamp(low + begin * (high - low), start.lower, start.upper),
                       std::clamp((end - begin) * (high - low), length.lower, length.neutral)});
      }
    return out;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const T height = T(s.body.p_WB.z()) - theta[1];
    if (height <= T(0)) return;
    const T carried = theta[0] * (height < theta[2] ? height : theta[2]);
    out.force_B += carried * s.g_B.cast<T>();
    out.lifted_mass += carried;  // it does not follow sideways
    if (height < theta[2]) out.force_B -= picked_up(s, theta[0]) * s.R_WB.row(2).transpose().cast<T>();
  }
};

}  // namespace

const Effect& hung_cable_effect() {
  static const HungCable effect;
  return effect;
}

}  // namespace omniflight::physics
