// The centre of mass is not where the model has it.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class ComOffset final : public WrenchEffect<ComOffset> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "com_offset",
        .term = "centre-of-mass offset",
        .equation = "dF = -m [dw x c + w x (w x c)], dM = -m c x f",
        .latex =
            R"(\Delta F = -m\,[\dot\omega \times c + \omega\times(\omega\times c)],\quad \Delta\tau = -m\, c \times f)",
        .source = "Newton, Euler; Klein and Morelli 2006",
        .parameters = {{"x", "c_x", "m", -0.05, 0.05, 0.005, 0, true},
                       {"y", "c_y", "m", -0.05, 0.05, 0.005, 0, true},
                       {"z", "c_z", "m", -0.1, 0.1, 0.005, 0, true}},
        .signals = {"attitude", "acc", "gyro"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"rotor_thrust_scale", "mocap_offset", "attachment_torque"},
        .separated_by = "hover at roll and pitch of +-30 deg or more",
        .hidden_by_modelled_thrust = "without torques it looks like an accelerometer that sits elsewhere",
        .words = {{"x", "y", "z"}, [](const KnownValues& v) {
                    return "the centre of mass is " + along_body(v) + " of its place";
                  }}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const Eigen::Matrix<T, 3, 1> c(theta[0], theta[1], theta[2]);
    const Eigen::Matrix<T, 3, 1> w = s.body.w_WB_B.cast<T>();
    const T m(s.mass);
    out.force_B -= m * w.cross(w.cross(c));
    out.torque_B += m * c.cross(s.g_B.cast<T>());
    Eigen::Matrix<T, 3, 3> cx;
    cx << T(0), -c[2], c[1], c[2], T(0), -c[0], -c[1], c[0], T(0);
    out.has_inertia = true;
    out.inertia.template topRightCorner<3, 3>() -= m * cx;
    out.inertia.template bottomLeftCorner<3, 3>() += m * cx;
  }
};

}  // namespace

const Effect& com_offset_effect() {
  static const ComOffset effect;
  return effect;
}

}  // namespace omniflight::physics
