// Rotors in the wash of other rotors of the same vehicle. Nothing of it depends on the tilt directly: the
// tilt moves and turns the wakes, and what they hit.
#include <array>
#include <cmath>

#include "effects/rotor_air.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class DownwashInterference final : public WrenchEffect<DownwashInterference> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "downwash_interference",
        .term = "downwash between rotors",
        .equation =
            "dF_j = k_z |Omega_j| n_j sum_i g_ij v_i [(1-m) d_i.n_j - m sgn T_j], d_i = -sgn(T_i) n_i, "
            "v_i = sqrt(|T_i|/(2 rho pi R_i^2)), g_ij = 1/2 (1 + z/sqrt(z^2+R_i^2)) R_i^2/B^2 exp(-q^2/B^2), "
            "B^2 = R_j^2/2 + (beta R_i)^2; z, q: of hub j along and off the wake axis of i",
        .latex =
            R"(\Delta F_j = k_z|\Omega_j|\,n_j\sum_{i\ne j} g_{ij}v_i\,[(1-m)\,d_i\cdot n_j - m\,\mathrm{sgn}\,T_j],)"
            R"(\quad g_{ij} = \tfrac12\Big(1+\tfrac{z}{\sqrt{z^2+R_i^2}}\Big)\tfrac{R_i^2}{B^2}e^{-q^2/B^2},)"
            R"(\quad B^2 = \tfrac12R_j^2+(\beta R_i)^2)",
        .source =
            "actuator disc: axial growth of the induced velocity and contraction to R/sqrt 2 (Leishman "
            "2006), Gaussian wake of the same flux averaged over the other disc, thrust linear in inflow "
            "(RotorPy k_z); m: share of the wake that takes thrust whichever way it crosses the disc. "
            "Bazzana 2024 for the size",
        .parameters = {{"coefficient", "k_z", "kg/rad", 0, 0.004, 0.00021, 0, true},
                       {"width", "beta", "1", 0.3, 6, 0.7071, 0.7071, false},
                       {"mixing", "m", "1", 0, 1, 0, 0, false}},
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"tilt_efficiency", "rotor_thrust_scale", "thrust_scale"},
        .separated_by =
            "load moved between upper and lower rotors in the null space; alpha sweep; flight "
            "upside down"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::exp;
    const auto rotors = s.all_rotors();
    struct Wash {
      double velocity = 0, square = 0;  ///< m/s at the disc; m^2 of its radius
      Vec3 away;                        ///< where it goes, unit
    };
    std::array<Wash, vehicle::kMaxRotors> washes;
    for (std::size_t i = 0; i < rotors.size(); ++i) {
      const RotorSituation& a = rotors[i];
      washes[i] = {hover_induced_velocity(a, s.environment.air_density), a.radius * a.radius,
                   -thrust_sign(a) * a.n_B};
    }
    // one over B^2, which is the same for rotors of one size
    double of_a = -1, of_b = -1;
    T inverse(0);
    for (std::size_t j = 0; j < rotors.size(); ++j) {
      const RotorSituation& b = rotors[j];
      T sum(0);
      for (std::size_t i = 0; i < rotors.size(); ++i) {
        const Wash& a = washes[i];
        if (i == j || a.velocity == 0.0) continue;
        const Vec3 to = b.p_BR - rotors[i].p_BR;
        const double z = to.dot(a.away), off = std::max(0.0, to.squaredNorm() - z * z);
        const double grown = 0.5 * (1.0 + z / std::sqrt(z * z + a.square));
        if (a.square != of_a || b.radius != of_b) {
          inverse = T(1) / (T(0.5 * b.radius * b.radius) + theta[1] * theta[1] * T(a.square));
          of_a = a.square;
          of_b = b.radius;
        }
        const T g = T(grown * a.square * a.velocity) * inverse * exp(T(-off) * inverse);
        sum += g * ((T(1) - theta[2]) * T(a.away.dot(b.n_B)) - theta[2] * T(thrust_sign(b)));
      }
      out.add_at(b.p_BR, theta[0] * T(std::abs(b.speed)) * sum * b.n_B.cast<T>());
    }
  }
};

}  // namespace

const Effect& downwash_interference_effect() {
  static const DownwashInterference effect;
  return effect;
}

}  // namespace omniflight::physics
