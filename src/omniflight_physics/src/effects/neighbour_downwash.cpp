// Below another multirotor: its wash is a turbulent jet that presses on this one.
#include "effects/rotor_air.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class NeighbourDownwash final : public WrenchEffect<NeighbourDownwash> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "neighbour_downwash",
        .term = "downwash of a neighbour",
        .equation =
            "dF_i = -R^T e3 K/(N pi b^2) exp(-2 q^2/b^2) [(1 + z/sqrt(z^2+b_0^2))/2]^2, b = b_0 + s "
            "max(z, 0); z, q: of hub i of N below and beside the neighbour, K = C_dA T_neighbour",
        .latex =
            R"(\Delta F_i = -R^Te_3\,\frac{K}{N\pi b^2}\,e^{-2q^2/b^2}\Big[\tfrac12\Big(1+\tfrac{z}{\sqrt{z^2+b_0^2}}\Big)\Big]^2,)"
            R"(\quad b = b_0 + s\max(z,0))",
        .source =
            "round turbulent jet with the momentum of the neighbour's thrust (Pope 2000: spread 0.114), "
            "shown below multirotors by Bauersfeld et al. 2024; near field: actuator disc",
        .parameters = {{"strength", "K", "N m2", 0, 10, 0.3, 0, true},
                       {"spread", "s", "1", 0.03, 0.4, 0.114, 0.114, false},
                       {"source_radius", "b_0", "m", 0.02, 1, 0.2, 0.2, false}},
        .signals = {"position", "attitude", "neighbour"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"constant_pull", "gust", "payload_mass"},
        .separated_by = "pass below the neighbour at two heights, and away from it"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::exp;
    using std::sqrt;
    const Vec3 down_B = -s.R_WB.row(2).transpose();
    for (const Neighbour& n : s.all_neighbours()) {
      for (const RotorSituation& r : s.all_rotors()) {
        const Vec3 to = hub_position(s, r) - n.p_WN;
        const double below = -to.z(), off = to.head<2>().squaredNorm();
        const T b0 = theta[2], b = b0 + theta[1] * T(std::max(below, 0.0));
        const T grown = T(0.5) * (T(1) + T(below) / sqrt(T(below * below) + b0 * b0));
        const T f =
            theta[0] * grown * grown * exp(T(-2.0 * off) / (b * b)) / (T(s.rotor_count * kPi) * b * b);
        out.add_at(r.p_BR, f * down_B.cast<T>());
      }
    }
  }
};

}  // namespace

const Effect& neighbour_downwash_effect() {
  static const NeighbourDownwash effect;
  return effect;
}

}  // namespace omniflight::physics
