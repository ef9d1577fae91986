// A rotor that descends into its own wake: the induced velocity is larger than momentum theory says.
#include "effects/rotor_air.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

/// Measured minus theoretical induced velocity, both per hover value, at climb speed x per hover value. Zero
/// in hover, in climb, and beyond the descent at which the two meet (x = -1.57).
double excess_inflow(double x) {
  if (!(x < 0.0 && x > -2.0)) return 0.0;
  const double measured = 1.0 + x * (-1.125 + x * (-1.372 + x * (-1.718 - 0.655 * x)));
  const double theory = -0.5 * x + std::sqrt(0.25 * x * x + 1.0);
  return std::max(0.0, measured - theory);
}

class VortexRing final : public WrenchEffect<VortexRing> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "vortex_ring",
        .term = "vortex ring state",
        .equation =
            "dT_i = -k_z |Omega_i| v_i e(x_i), x = sgn(T) n.v / v_i, v_i = sqrt(|T_i|/(2 rho pi R^2)), "
            "e = max(0, 1 - 1.125x - 1.372x^2 - 1.718x^3 - 0.655x^4 - (-x/2 + sqrt(x^2/4 + 1))), x < 0",
        .latex = R"(\Delta T_i = -k_z|\Omega_i|\,v_i\,e(x_i),\quad e(x) = \max\!\big(0,\;)"
                 R"(1-1.125x-1.372x^2-1.718x^3-0.655x^4 + \tfrac x2 - \sqrt{\tfrac{x^2}4+1}\big),\; x<0)",
        .source =
            "Leishman 2006, fit of measured induced velocity in descent, against momentum theory; thrust "
            "linear in inflow",
        .parameters = {{"coefficient", "k_z", "kg/rad", 0, 0.004, 0.00021, 0, true}},
        .signals = {"rotor_speed", "velocity", "attitude"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"axial_inflow"},
        .separated_by = "descent at three speeds: the loss has a maximum near the induced velocity of hover"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (const RotorSituation& r : s.all_rotors()) {
      const double v = hover_induced_velocity(r, s.environment.air_density);
      if (v == 0.0) continue;
      const Vec3 push = thrust_sign(r) * r.n_B;
      const double loss = std::abs(r.speed) * v * excess_inflow(push.dot(hub_velocity(s, r)) / v);
      out.add_at(r.p_BR, theta[0] * (-loss * push).cast<T>());
    }
  }
};

}  // namespace

const Effect& vortex_ring_effect() {
  static const VortexRing effect;
  return effect;
}

}  // namespace omniflight::physics
