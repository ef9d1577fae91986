// All tilting rotors stand at another tilt than the one that is commanded and reported.
#include "effects/table.hpp"
#include "effects/turned_rotors.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class TiltOffset final : public WrenchEffect<TiltOffset> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "tilt_offset",
        .term = "common tilt offset",
        .equation =
            "dn_i = n_i(alpha + d_alpha) - n_i(alpha), dF = sum T_i dn_i, dM = sum T_i (r_i x dn_i + "
            "kappa s_i dn_i)",
        .latex =
            R"(\delta n_i = n_i(\alpha+\delta_\alpha) - n_i(\alpha),\quad \Delta F = \sum_i T_i\,\delta n_i,)"
            R"(\quad \Delta\tau = \sum_i T_i\,(r_i\times\delta n_i + \kappa s_i\,\delta n_i))",
        .source = "rotation of the thrust axis about the tilt axis, exact",
        .parameters = {{"offset", "d_alpha", "rad", -0.2, 0.2, 0.035, 0, false}},
        .signals = {"rotor_speed", "alpha"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"rotor_axis_misalignment", "thrust_scale", "tilt_efficiency", "tilt_servo_lag"},
        .separated_by = "alpha sweep; lateral force and yaw steps at two tilts",
        .words = {{"offset"}, [](const KnownValues& v) {
                    return "the rotors stand " + in_degrees(v("offset")) +
                           by_sign(v("offset"), " more", " less") + " tilted than they say";
                  }}};
    return info;
  }
  bool linear_in_thrust() const override { return true; }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    add_turned_rotors(s, theta[0], out);
  }
};

}  // namespace

const Effect& tilt_offset_effect() {
  static const TiltOffset effect;
  return effect;
}

}  // namespace omniflight::physics
