// The floor raises the thrust of a rotor that is close to it.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class GroundEffect final : public WrenchEffect<GroundEffect> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "ground_effect",
        .term = "ground effect",
        .equation = "T/T_inf = 1 + rho_g (R/4h)^2",
        .latex = R"(T/T_\infty = 1 + \rho_g \left(\tfrac{R}{4h}\right)^2)",
        .source = "Cheeseman and Bennett 1955, first order; Sanchez-Cuevas 2017 for rho_g",
        .parameters = {{"strength", "rho_g", "1", 0, 30, 2, 0, true}},
        .signals = {"rotor_speed", "position", "attitude"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "hung_cable", "payload_mass"},
        .separated_by = "slow descent and climb below half a metre"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const double height = s.body.p_WB.z() + s.R_WB.row(2).dot(r.p_BR) - s.environment.floor_z;
      const double ratio = r.radius / (4.0 * std::max(height, 0.5 * r.radius));
      const Vec3 f = r.thrust * ratio * ratio * r.n_B;
      out.add_at(r.p_BR, theta[0] * f.cast<T>());
    }
  }
};

}  // namespace

const Effect& ground_effect_effect() {
  static const GroundEffect effect;
  return effect;
}

}  // namespace omniflight::physics
