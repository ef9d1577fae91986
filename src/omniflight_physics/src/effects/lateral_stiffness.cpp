// A force towards an anchor in the horizontal plane, as of a taut overhead rope.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class LateralStiffness final : public WrenchEffect<LateralStiffness> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "lateral_stiffness",
                                 .term = "lateral stiffness",
                                 .equation = "dF = -k_xy R^T (p - p_A)_xy",
                                 .latex = R"(\Delta F = -k_{xy} R^T (p-p_A)_{xy})",
                                 .source = "linearised taut rope, k = T/l",
                                 .parameters = {{"stiffness", "k_xy", "N/m", 0, 50, 1, 0, false},
                                                {"anchor_x", "p_Ax", "m", -5, 5, 0, 0, false},
                                                {"anchor_y", "p_Ay", "m", -5, 5, 0, 0, false}},
                                 .signals = {"position", "attitude"},
                                 .channels = {"Fx", "Fy", "Fz"},
                                 .stage = Stage::wrench,
                                 .aliases = {"catenary", "wind"},
                                 .separated_by = "lateral steps in both directions",
                                 .words = {{"stiffness"}, [](const KnownValues& v) {
                                             return "a sideways pull back of " + two_digits(v("stiffness")) +
                                                    " N per m";
                                           }}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const Eigen::Matrix<T, 3, 1> f(-theta[0] * (s.body.p_WB.x() - theta[1]),
                                   -theta[0] * (s.body.p_WB.y() - theta[2]), T(0));
    out.force_B += s.R_WB.transpose().cast<T>() * f;
  }
};

}  // namespace

const Effect& lateral_stiffness_effect() {
  static const LateralStiffness effect;
  return effect;
}

}  // namespace omniflight::physics
