// The flow of a rotor needs time: until the air follows a quick change of speed, thrust overshoots (induced
// velocity, k_v > 0) or falls short (circulation of the blades, k_v < 0).
#include "effects/table.hpp"
#include "effects/thrust_change.hpp"

namespace omniflight::physics {
namespace {

class DynamicInflow final : public MemoryEffect<DynamicInflow, vehicle::kMaxRotors> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "dynamic_inflow",
        .term = "dynamic inflow",
        .equation =
            "dT_i = -k_v |Omega_i| (w_i - w_qs), tau dw_i/dt = w_qs - w_i, w_qs = sign(T) sqrt(|T|/(2 rho "
            "A))",
        .latex =
            R"(\Delta T_i = -k_v|\Omega_i|(w_i-w_{qs}),\quad \tau\dot w_i = w_{qs}-w_i,\quad w_{qs} = \sqrt{T_i/2\rho A})",
        .source =
            "Pitt and Peters 1981, uniform inflow; momentum theory (Leishman 2006); k_v < 0: lift that builds "
            "up late (Wagner 1925)",
        .parameters = {{"coefficient", "k_v", "kg/rad", -0.01, 0.01, 0.0002, 0, true},
                       {"time_constant", "tau", "s", 0.002, 0.2, 0.02, 0.02, false}},
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"motor_lag", "rotor_inertia"},
        .separated_by =
            "steps of thrust with telemetry of the speeds: the force does not follow the square of the speed "
            "at once"};
    return info;
  }

  template <class T>
  void start(const Situation& s, const T*, T* w) const {
    for (int i = 0; i < vehicle::kMaxRotors; ++i) w[i] = T(i < s.rotor_count ? settled(s, i) : 0.0);
  }
  template <class T>
  void rate(const Situation& s, const T* theta, const T* w, T* dw) const {
    for (int i = 0; i < vehicle::kMaxRotors; ++i)
      dw[i] = i < s.rotor_count ? T((T(settled(s, i)) - w[i]) / theta[1]) : T(0);
  }
  template <class T>
  void wrench(const Situation& s, const T* theta, const T* w, WrenchT<T>& out) const {
    for (int i = 0; i < s.rotor_count; ++i) {
      const RotorSituation& r = s.rotors[static_cast<std::size_t>(i)];
      add_thrust(r, T(-theta[0] * std::abs(r.speed) * (w[i] - T(settled(s, i)))), out);
    }
  }

 private:
  /// Induced velocity [m/s] once the inflow has settled, along -n for positive thrust.
  static double settled(const Situation& s, int i) {
    const RotorSituation& r = s.rotors[static_cast<std::size_t>(i)];
    if (r.radius <= 0) return 0.0;
    const double w =
        std::sqrt(std::abs(r.thrust) / (2 * s.environment.air_density * kPi * r.radius * r.radius));
    return r.thrust < 0 ? -w : w;
  }
};

}  // namespace

const Effect& dynamic_inflow_effect() {
  static const DynamicInflow effect;
  return effect;
}

}  // namespace omniflight::physics
