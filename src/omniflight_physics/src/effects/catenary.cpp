// A cable between the vehicle and a point on the floor: it hangs, lies on the floor and is stretched.
#include "catenary.hpp"
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class Catenary final : public WrenchEffect<Catenary> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "catenary",
        .term = "catenary",
        .equation =
            "dF = R^T (H u - V e3), (H, V) of an elastic catenary of length L with floor; u horizontal, "
            "towards the anchor",
        .latex =
            R"(x = [L-b]_+ + a\,(\mathrm{asinh}\tfrac ba-\mathrm{asinh}\tfrac ua)+eaL,\ z = \sqrt{a^2+b^2}-\sqrt{a^2+u^2}+\tfrac e2(b^2-u^2),\ u=[b-L]_+,\ H=\lambda ga,\ V=\lambda gb)",
        .source =
            "Irvine 1981, elastic catenary with frictionless floor as in Jonkman 2007; e = g/c^2, c^2 = "
            "EA/lambda; quasi-static",
        .parameters = {{"linear_density", "lambda", "kg/m", 0, 1.5, 0.05, 0, true},
                       {"length", "L", "m", 0.1, 20, 2, 2, false},
                       {"anchor_x", "x_A", "m", -20, 20, 0, 0, false},
                       {"anchor_y", "y_A", "m", -20, 20, 0, 0, false},
                       {"stretch_speed", "c", "m/s", 50, 5000, 300, 300, false}},
        .signals = {"position", "attitude"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"lateral_stiffness", "wind", "wall_effect", "hung_cable"},
        .separated_by = "a lateral square at two heights"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::sqrt;
    using V = Eigen::Matrix<T, 3, 1>;
    const double height = s.body.p_WB.z() - s.environment.floor_z;
    if (height <= 1e-3) return;
    const V to(theta[2] - T(s.body.p_WB.x()), theta[3] - T(s.body.p_WB.y()), T(0));
    const T distance = sqrt(to.squaredNorm() + T(1e-18));
    const T stretch = T(s.environment.gravity) / (theta[4] * theta[4]);
    const auto [a, b] = solve_catenary(distance, height, theta[1], stretch);
    const T weight = theta[0] * T(s.environment.gravity);
    const V f_W = weight * (a / distance * to - V(T(0), T(0), b));
    out.force_B += s.R_WB.transpose().cast<T>() * f_W;
  }
};

}  // namespace

const Effect& catenary_effect() {
  static const Catenary effect;
  return effect;
}

}  // namespace omniflight::physics
