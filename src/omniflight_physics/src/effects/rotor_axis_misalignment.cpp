// Rotor axes that do not point where the model has them.
#include "effects/regressor.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

constexpr int kLeaningRotors = kMaxParameters / 3;

class RotorAxisMisalignment final : public RegressorEffect<RotorAxisMisalignment> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "rotor_axis_misalignment",
        .term = "rotor axis misalignment",
        .equation =
            "dn_i = (a_i t_i + b_i n_i x t_i) x n_i, dF = sum T_i dn_i, dM = sum T_i (r_i x dn_i + "
            "kappa s_i dn_i)",
        .latex =
            R"(\delta n_i = (a_i t_i + b_i\, n_i\times t_i)\times n_i,\quad \Delta F = \sum_i T_i\,\delta n_i,)"
            R"(\quad \Delta\tau = \sum_i T_i\,(r_i\times\delta n_i + \kappa s_i\,\delta n_i))",
        .source =
            "first-order rotation of the thrust axis; t_i is the tilt axis (of a fixed rotor: body x, or "
            "y where that is along n), rotors 1 to 8",
        .parameters = parameters(),
        .signals = {"rotor_speed"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"tilt_offset", "rotor_thrust_scale", "mocap_offset"},
        .separated_by = "hover at six attitudes or more, with rotor speeds moved in the null space",
        .hidden_by_modelled_thrust = "without torques it looks like an accelerometer mounted askew",
        .parameters_per_rotor = 2};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  void columns(const Situation& s, Columns& out) const {
    int k = 0;
    for (const RotorSituation& r : s.all_rotors()) {
      if (k >= 2 * kLeaningRotors) return;
      Vec3 t = r.tilt_axis_B;
      if (t.isZero()) t = std::abs(r.n_B.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
      t = (t - t.dot(r.n_B) * r.n_B).normalized();
      for (const Vec3& dn : {Vec3(t.cross(r.n_B)), t}) {  // (n x t) x n = t
        out.col(k).head<3>() = r.thrust * dn;
        out.col(k).tail<3>() = r.thrust * (r.p_BR.cross(dn) + r.spin * r.drag_ratio * dn);
        ++k;
      }
    }
  }

 private:
  static std::vector<Parameter> parameters() {
    std::vector<Parameter> out;
    for (int i = 1; i <= kLeaningRotors; ++i) {
      const std::string n = std::to_string(i);
      const double along = i % 2 ? 0.02 : -0.015, across = i % 3 ? 0.01 : -0.02;
      out.push_back({"rotor" + n + "_tilt", "a_" + n, "rad", -0.15, 0.15, along, 0, true});
      out.push_back({"rotor" + n + "_splay", "b_" + n, "rad", -0.15, 0.15, across, 0, true});
    }
    return out;
  }
};

}  // namespace

const Effect& rotor_axis_misalignment_effect() {
  static const RotorAxisMisalignment effect;
  return effect;
}

}  // namespace omniflight::physics
