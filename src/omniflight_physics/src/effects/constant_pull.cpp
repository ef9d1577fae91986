// A constant force in the world, such as a slack rope or a resting cable.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

std::string steady_pull(const KnownValues& v) {
  const Vec3 f(v("x"), v("y"), v("z"));
  const double level = f.head<2>().norm();
  const char* where = std::abs(f.z()) > 2 * level ? by_sign(f.z(), " upward", " downward")
                      : level > 2 * std::abs(f.z())
                          ? " sideways"
                          : by_sign(f.z(), " sideways and up", " sideways and down");
  return "a steady pull of " + two_digits(f.norm()) + " N" + where;
}

class ConstantPull final : public WrenchEffect<ConstantPull> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "constant_pull",
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
        .separated_by = "vertical multisine: a pull has no inertia",
        .hidden_by_modelled_thrust =
            "it scales or shifts a thrust that is only modelled, for want of rotor speeds",
        .words = {{"x", "y", "z"}, steady_pull}};
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
