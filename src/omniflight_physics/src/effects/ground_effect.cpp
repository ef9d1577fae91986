// The floor raises the thrust of a rotor that blows towards it from close by.
#include "effects/rotor_air.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class GroundEffect final : public WrenchEffect<GroundEffect> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "ground_effect",
        .term = "ground effect",
        .equation =
            "dT_i = T_i c_i x/(1 - x), x = min(rho_g (R/4h_i)^2, 3/4), c_i = max(0, cosine of the wash "
            "with the vertical)",
        .latex =
            R"(\frac{T}{T_\infty} = 1 + c_i\frac{x}{1-x},\quad x = \min\!\Big(\rho_g \big(\tfrac{R}{4h_i}\big)^2, \tfrac34\Big))",
        .source =
            "Cheeseman and Bennett 1955 (rho_g = 1: a source and its mirror image below the floor); rho_g as "
            "in Powers et al. 2013 for whole multirotors",
        .parameters = {{"strength", "rho_g", "1", 0, 10, 1, 0, false}},
        .signals = {"rotor_speed", "position", "attitude"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "hung_cable", "payload_mass"},
        .separated_by = "slow descent and climb below half a metre",
        .tells_floor_height = true};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const double wash = thrust_sign(r) * s.R_WB.row(2).dot(r.n_B);
      if (wash <= 0) continue;  // blows upwards
      const double height = hub_position(s, r).z() - s.environment.floor_z;
      const double ratio = r.radius / (4.0 * std::max(height, 0.05 * r.radius));
      T x = theta[0] * T(ratio * ratio);
      if (x > T(0.75)) x = T(0.75);
      out.add_at(r.p_BR, x / (T(1) - x) * (r.thrust * wash * r.n_B).cast<T>());
    }
  }
};

}  // namespace

const Effect& ground_effect_effect() {
  static const GroundEffect effect;
  return effect;
}

}  // namespace omniflight::physics
