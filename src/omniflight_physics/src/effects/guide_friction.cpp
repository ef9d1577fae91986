// Coulomb friction on a vertical guide, or of something that is dragged over the floor.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class GuideFriction final : public WrenchEffect<GuideFriction> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "guide_friction",
        .term = "Coulomb friction",
        .equation = "dF = -R^T [F_v tanh(v_z/v0) e3 + F_h tanh(|v_xy|/v0) v_xy/|v_xy|]",
        .latex =
            R"(\Delta F = -R^T\Big[F_v\tanh\tfrac{v_z}{v_0}\,e_3 + F_h\tanh\tfrac{|v_{xy}|}{v_0}\,\tfrac{v_{xy}}{|v_{xy}|}\Big])",
        .source = "Coulomb's law, smooth near rest; F = mu N of a vertical guide and of the floor",
        .parameters = {{"vertical", "F_v", "N", 0, 5, 0.2, 0, true},
                       {"horizontal", "F_h", "N", 0, 5, 0.1, 0, true},
                       {"transition", "v_0", "m/s", 0.005, 0.1, 0.03, 0.03, false}},
        .signals = {"velocity", "attitude"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"hung_cable", "parasitic_drag", "rotor_drag"},
        .separated_by = "up and down at the same speed, and at two speeds",
        .words = {{"vertical", "horizontal"}, [](const KnownValues& v) {
                    return "friction of " + two_digits(std::max(v("vertical"), v("horizontal"))) +
                           " N against the motion";
                  }}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::tanh;
    const Vec3& v = s.body.v_WB_W;
    const Vec3 level(v.x(), v.y(), 0);
    const double speed = level.norm();
    Eigen::Matrix<T, 3, 1> f(T(0), T(0), -theta[0] * tanh(T(v.z()) / theta[2]));
    if (speed > 0) f -= theta[1] * tanh(T(speed) / theta[2]) * (level / speed).cast<T>();
    out.force_B += s.R_WB.transpose().cast<T>() * f;
  }
};

}  // namespace

const Effect& guide_friction_effect() {
  static const GuideFriction effect;
  return effect;
}

}  // namespace omniflight::physics
