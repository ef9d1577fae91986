// Single rotors give more or less thrust than their coefficient says: damage, spread of production.
#include "effects/table.hpp"
#include "effects/thrust_change.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

std::string single_rotors(const KnownValues& v) {
  std::string out;
  for (const auto& [name, scale] : v.all())
    if (name.starts_with("scale_") && scale != 0)
      out += (out.empty() ? "rotor " : ", rotor ") + name.substr(6) + " gives " + in_percent(scale) +
             by_sign(scale, " more", " less") + " thrust than modelled";
  return out;
}

class RotorThrustScale final : public WrenchEffect<RotorThrustScale> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "rotor_thrust_scale",
        .term = "thrust coefficient error of single rotors",
        .equation = "dT_i = eps_i T_i",
        .latex = R"(\Delta T_i = \varepsilon_i T_i)",
        .source = "definition; the first eight rotors",
        .parameters = {{"scale_1", "eps_1", "1", -0.9, 0.5, -0.1, 0, true},
                       {"scale_2", "eps_2", "1", -0.9, 0.5, 0, 0, true},
                       {"scale_3", "eps_3", "1", -0.9, 0.5, 0, 0, true},
                       {"scale_4", "eps_4", "1", -0.9, 0.5, 0, 0, true},
                       {"scale_5", "eps_5", "1", -0.9, 0.5, 0, 0, true},
                       {"scale_6", "eps_6", "1", -0.9, 0.5, 0, 0, true},
                       {"scale_7", "eps_7", "1", -0.9, 0.5, 0, 0, true},
                       {"scale_8", "eps_8", "1", -0.9, 0.5, 0, 0, true}},
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"com_offset", "rotor_axis_misalignment", "rotor_position_error", "thrust_scale"},
        .separated_by =
            "excitation in the null space of the rotors: no motion, yet another torque for every rotor",
        .hidden_by_modelled_thrust =
            "it scales or shifts a thrust that is only modelled, for want of rotor speeds",
        .parameters_per_rotor = 1,
        .words = {{"scale_1", "scale_2", "scale_3", "scale_4", "scale_5", "scale_6", "scale_7", "scale_8"},
                  single_rotors}};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    for (int i = 0; i < std::min(s.rotor_count, 8); ++i) {
      const RotorSituation& r = s.rotors[static_cast<std::size_t>(i)];
      add_thrust(r, T(theta[i] * r.thrust), out);
    }
  }
};

}  // namespace

const Effect& rotor_thrust_scale_effect() {
  static const RotorThrustScale effect;
  return effect;
}

}  // namespace omniflight::physics
