// A ceiling close above a rotor: the air comes in through the gap, the induced velocity falls, the thrust
// rises.
#include "effects/rotor_air.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class CeilingEffect final : public WrenchEffect<CeilingEffect> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "ceiling_effect",
        .term = "ceiling effect",
        .equation =
            "dT_i = k_z |Omega_i| v_i (1 - 1/sqrt(1 + (R/d_i)^2/32)) c_i, d_i = h_c - h_i, v_i = "
            "sqrt(|T_i|/(2 rho pi R^2)), c_i = max(0, cosine of the intake with the vertical)",
        .latex =
            R"(\Delta T_i = k_z|\Omega_i|\,v_i\Big(1-\tfrac1{\sqrt{1+(R/d_i)^2/32}}\Big)c_i,\quad d_i = h_c-h_i)",
        .source =
            "momentum balance of a disc below a plate with radial inflow through the gap (the idea of Hsiao "
            "and Chirarattananon 2019; derivation in docs/explanation/physics.md), thrust linear in inflow",
        .parameters = {{"coefficient", "k_z", "kg/rad", 0, 0.004, 0.00021, 0, true},
                       {"height", "h_c", "m", 0.2, 20, 2.2, 2.2, false}},
        .signals = {"rotor_speed", "position", "attitude"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "payload_mass", "hung_cable"},
        .separated_by = "slow climb to the upper stop and back"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::sqrt;
    for (const RotorSituation& r : s.all_rotors()) {
      const double sign = thrust_sign(r), facing = sign * s.R_WB.row(2).dot(r.n_B);
      if (facing <= 0 || !(r.radius > 0)) continue;
      const double v = hover_induced_velocity(r, s.environment.air_density);
      T gap = theta[1] - T(hub_position(s, r).z());
      if (gap < T(0.05 * r.radius)) gap = T(0.05 * r.radius);
      const T ratio = T(r.radius) / gap;
      const T gain = T(1) - T(1) / sqrt(T(1) + ratio * ratio / T(32));
      const T dT = theta[0] * T(std::abs(r.speed) * v * facing * sign) * gain;
      out.add_at(r.p_BR, dT * r.n_B.cast<T>());
    }
  }
};

}  // namespace

const Effect& ceiling_effect_effect() {
  static const CeilingEffect effect;
  return effect;
}

}  // namespace omniflight::physics
