// A vertical wall or net beside the vehicle pulls (or pushes) the rotors near it.
#include "effects/rotor_air.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class WallEffect final : public WrenchEffect<WallEffect> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "wall_effect",
        .term = "wall effect",
        .equation = "dF_i = k_w |T_i| exp(-d_i/l) R^T e, e = (cos psi, sin psi, 0), d_i = max(0, D - e.p_i)",
        .latex = R"(\Delta F_i = k_w |T_i|\, e^{-d_i/\ell}\, R^T e,\quad e = (\cos\psi, \sin\psi, 0),\quad )"
                 R"(d_i = \max(0,\, D - e\cdot p_i))",
        .source =
            "empirical form: a share of the thrust that fades with distance, towards the wall for k_w > 0; "
            "e points from the world origin to the wall at distance D",
        .parameters = {{"strength", "k_w", "1", -0.3, 0.3, 0.02, 0, true},
                       {"reach", "l", "m", 0.03, 1.5, 0.2, 0.2, false},
                       {"azimuth", "psi", "rad", -3.15, 3.15, 0, 0, false},
                       {"distance", "D", "m", 0.2, 20, 0.7, 0.7, false}},
        .signals = {"rotor_speed", "position", "attitude"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"lateral_stiffness", "catenary", "wind", "constant_pull"},
        .separated_by = "approach to each wall: the force grows only near it"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::cos;
    using std::exp;
    using std::sin;
    const Eigen::Matrix<T, 3, 1> e(cos(theta[2]), sin(theta[2]), T(0));
    const Eigen::Matrix<T, 3, 1> e_B = s.R_WB.transpose().cast<T>() * e;
    for (const RotorSituation& r : s.all_rotors()) {
      T gap = theta[3] - e.dot(hub_position(s, r).cast<T>());
      if (gap < T(0)) gap = T(0);
      const Eigen::Matrix<T, 3, 1> f = theta[0] * T(std::abs(r.thrust)) * exp(-gap / theta[1]) * e_B;
      out.add_at(r.p_BR, f);
    }
  }
};

}  // namespace

const Effect& wall_effect_effect() {
  static const WallEffect effect;
  return effect;
}

}  // namespace omniflight::physics
