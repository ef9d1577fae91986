// Rotors that do not sit where the model has them.
#include "effects/regressor.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

constexpr int kPlacedRotors = kMaxParameters / 3;

class RotorPositionError final : public RegressorEffect<RotorPositionError> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "rotor_position_error",
        .term = "rotor position error",
        .equation = "dM = sum dr_i x n_i T_i",
        .latex = R"(\Delta\tau = \sum_i \delta r_i \times n_i\, T_i)",
        .source = "lever of the thrust; rotors 1 to 8, body axes",
        .parameters = parameters(),
        .signals = {"rotor_speed"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"com_offset", "rotor_thrust_scale", "rotor_axis_misalignment"},
        .separated_by = "rotor speeds moved in the null space, at several tilts and attitudes",
        .parameters_per_rotor = 3};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  void columns(const Situation& s, Columns& out) const {
    int k = 0;
    for (const RotorSituation& r : s.all_rotors()) {
      if (k >= 3 * kPlacedRotors) return;
      for (int axis = 0; axis < 3; ++axis) out.col(k++).tail<3>() = r.thrust * Vec3::Unit(axis).cross(r.n_B);
    }
  }

 private:
  static std::vector<Parameter> parameters() {
    std::vector<Parameter> out;
    for (int i = 1; i <= kPlacedRotors; ++i) {
      const std::string n = std::to_string(i);
      const double typical[] = {i % 2 ? 0.003 : -0.002, i % 3 ? 0.002 : -0.003, i % 4 ? 0.001 : -0.002};
      for (int axis = 0; axis < 3; ++axis)
        out.push_back({"rotor" + n + "_" + "xyz"[axis], "dr_" + n + "xyz"[axis], "m", -0.03, 0.03,
                       typical[axis], 0, true});
    }
    return out;
  }
};

}  // namespace

const Effect& rotor_position_error_effect() {
  static const RotorPositionError effect;
  return effect;
}

}  // namespace omniflight::physics
