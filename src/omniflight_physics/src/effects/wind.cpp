// Steady wind on the body, as the difference it makes to a quadratic drag of known area.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class Wind final : public WrenchEffect<Wind> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "wind",
        .term = "steady wind",
        .equation = "dF = 1/2 rho C_dA R^T (|w - v| (w - v) + |v| v)",
        .latex = R"(\Delta F = \tfrac12\rho\,C_dA\,R^T\,(|w-v|(w-v) + |v|v))",
        .source = "standard drag equation",
        .parameters = {{"x", "w_x", "m/s", -10, 10, 0.5, 0, false},
                       {"y", "w_y", "m/s", -10, 10, 0.5, 0, false},
                       {"area", "C_dA", "m2", 0.001, 0.3, 0.02, 0.02, false}},
        .signals = {"velocity", "attitude"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"mocap_tilt", "constant_pull", "parasitic_drag"},
        .separated_by = "heading does not help; compare the accelerometer at rest with motion capture",
        .words = {{"x", "y"}, [](const KnownValues& v) {
                    return "a steady wind of " + two_digits(std::hypot(v("x"), v("y"))) + " m/s";
                  }}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::sqrt;
    const Vec3& v = s.body.v_WB_W;
    const Eigen::Matrix<T, 3, 1> d(theta[0] - v.x(), theta[1] - v.y(), T(-v.z()));
    const T speed = sqrt(d.squaredNorm() + T(1e-12));
    const double own = std::sqrt(v.squaredNorm() + 1e-12);
    const Eigen::Matrix<T, 3, 1> f_W =
        T(0.5 * s.environment.air_density) * theta[2] * (speed * d + (own * v).cast<T>());
    out.force_B += s.R_WB.transpose().cast<T>() * f_W;
  }
};

}  // namespace

const Effect& wind_effect() {
  static const Wind effect;
  return effect;
}

}  // namespace omniflight::physics
