// The moments of inertia differ from the model.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class InertiaError final : public WrenchEffect<InertiaError> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "inertia_error",
        .term = "inertia error",
        .equation = "dM = -(dJ dw + w x dJ w)",
        .latex = R"(\Delta\tau = -(\Delta J\,\dot\omega + \omega\times \Delta J\,\omega))",
        .source = "Euler",
        .parameters = {{"xx", "dJ_xx", "kg m2", -0.05, 0.05, 0.001, 0, true},
                       {"yy", "dJ_yy", "kg m2", -0.05, 0.05, 0.001, 0, true},
                       {"zz", "dJ_zz", "kg m2", -0.05, 0.05, 0.001, 0, true}},
        .signals = {"gyro"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"thrust_scale", "rotor_inertia"},
        .separated_by = "angular multisine on three axes with known rotor torque"};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const Eigen::Matrix<T, 3, 1> w = s.body.w_WB_B.cast<T>();
    const Eigen::Matrix<T, 3, 1> dJw(theta[0] * w[0], theta[1] * w[1], theta[2] * w[2]);
    out.torque_B -= w.cross(dJw);
    out.has_inertia = true;
    for (int k = 0; k < 3; ++k) out.inertia(3 + k, 3 + k) += theta[k];
  }
};

}  // namespace

const Effect& inertia_error_effect() {
  static const InertiaError effect;
  return effect;
}

}  // namespace omniflight::physics
