// The tilt follows its command later and with more play than the vehicle file tells: both parameters add to
// its tilt.time_constant_s and tilt.backlash_deg.
#include "effects/table.hpp"
#include "effects/turned_rotors.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

constexpr double kQuickest = 0.02;  // s: a shorter lag is not seen on a recording's grid

/// The lag alone, as a wrench: the rotors stand at alpha_s while alpha is reported. Play shows in no smooth
/// motion.
class UnrecordedLag final : public MemoryEffect<UnrecordedLag, 1> {
 public:
  explicit UnrecordedLag(const EffectInfo& recorded) : info_(recorded) {
    info_.parameters.resize(1);
    info_.signals = {"rotor_speed", "alpha"};
    info_.channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  }
  const EffectInfo& info() const override { return info_; }

  // memory: the tilt at which the rotors stand [rad]
  template <class T>
  void start(const Situation& s, const T*, T* x) const {
    x[0] = T(s.alpha);
  }
  template <class T>
  void rate(const Situation& s, const T* theta, const T* x, T* dx) const {
    dx[0] = (T(s.alpha) - x[0]) / (theta[0] > T(kQuickest) ? theta[0] : T(kQuickest));
  }
  template <class T>
  void wrench(const Situation& s, const T*, const T* x, WrenchT<T>& out) const {
    add_turned_rotors(s, T(x[0] - T(s.alpha)), out);
  }

 private:
  EffectInfo info_;
};

class TiltServoLag final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "tilt_servo_lag",
        .term = "tilt servo lag and backlash",
        .equation = "d alpha_s/dt = (alpha_c - alpha_s)/tau_a, |alpha - alpha_s| <= b/2",
        .latex = R"(\dot\alpha_s = (\alpha_c-\alpha_s)/\tau_a,\quad |\alpha-\alpha_s|\le b/2)",
        .source = "first-order servo and the play operator",
        .parameters = {{"time_constant", "tau_a", "s", 0, 2, 0.15, 0, false},
                       {"backlash", "b", "rad", 0, 0.2, 0.02, 0, false}},
        .signals = {"alpha", "alpha_command"},
        .channels = {"alpha"},
        .stage = Stage::actuation,
        .aliases = {"tilt_offset", "tilt_efficiency"},
        .separated_by = "steps of the tilt in hover, up and down",
        .words = {{"time_constant"}, [](const KnownValues& v) {
                    return "the tilt follows " + two_digits(1e3 * v("time_constant")) +
                           " ms later than the vehicle file says";
                  }}};
    return info;
  }

  void alter_actuation(const vehicle::Vehicle&, const double* theta, Actuation& a) const override {
    a.tilt_time_constant += theta[0];
    a.tilt_backlash += theta[1];
  }

  const Effect* unrecorded_form() const override {
    static const UnrecordedLag form(info());
    return &form;
  }
  std::vector<double> from_unrecorded_form(const std::vector<double>& theta) const override {
    return {theta[0], info().parameters[1].neutral};
  }
};

}  // namespace

const Effect& tilt_servo_lag_effect() {
  static const TiltServoLag effect;
  return effect;
}

}  // namespace omniflight::physics
