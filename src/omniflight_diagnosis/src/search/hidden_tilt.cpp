#include "hidden_tilt.hpp"

#include "omniflight_physics/turned_rotors.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::Situation;

class HiddenTiltLag final : public physics::MemoryEffect<HiddenTiltLag, 1> {
 public:
  HiddenTiltLag() : info_(physics::find_effect("tilt_servo_lag")->info()) {
    info_.parameters.resize(1);  // play shows in no smooth motion
    info_.signals = {"rotor_speed", "alpha"};
    info_.channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  }
  const physics::EffectInfo& info() const override { return info_; }

  // memory: the tilt at which the rotors stand [rad]
  template <class T>
  void start(const Situation& s, const T*, T* x) const {
    x[0] = T(s.alpha);
  }
  template <class T>
  void rate(const Situation& s, const T* theta, const T* x, T* dx) const {
    constexpr double kQuickest = 0.02;  // s: what is quicker than the grid is nothing to it
    dx[0] = (T(s.alpha) - x[0]) / (theta[0] > T(kQuickest) ? theta[0] : T(kQuickest));
  }
  template <class T>
  void wrench(const Situation& s, const T*, const T* x, physics::WrenchT<T>& out) const {
    physics::add_turned_rotors(s, T(x[0] - T(s.alpha)), out);
  }

 private:
  physics::EffectInfo info_;
};

}  // namespace

const physics::Effect& hidden_tilt_lag() {
  static const HiddenTiltLag effect;
  return effect;
}

}  // namespace omniflight::diagnosis
