// A constant force in the world, such as a slack rope or a resting cable.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class ConstantPull final : public WrenchEffect<ConstantPull> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "constant_pull",
                                 .term = "constant pull",
                                 .equation = "dF = R^T F0",
                                 .latex = R"(\Delta F = R^T F_0)",
                                 .source = "definition",
                                 .parameters = {{"x", "F_x", "N", -10, 10, 0.2, 0, true},
                                                {"y", "F_y", "N", -10, 10, 0.2, 0, true},
                                                {"z", "F_z", "N", -20, 20, -1, 0, true}},
                                 .signals = {"attitude"},
                                 .channels = {"Fx", "Fy", "Fz"},
                                 .stage = Stage::wrench,
                                 .aliases = {"payload_mass", "hung_cable", "wind", "mocap_tilt"},
                                 .separated_by = "vertical multisine: a pull has no inertia"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const Eigen::Matrix<T, 3, 1> f(theta[0], theta[1], theta[2]);
    out.force_B += s.R_WB.transpose().cast<T>() * f;
  }
};

}  // namespace

const Effect& constant_pull_effect() {
  static const ConstantPull effect;
  return effect;
}

}  // namespace omniflight::physics
