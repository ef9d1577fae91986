#include "single_rotor.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>

#include "hidden_tilt.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::Effect;

constexpr int kRotors = 8;  ///< for which these effects have numbers

bool is_by_rotor(const Effect& effect) {
  const std::string& id = effect.info().id;
  return id == "rotor_thrust_scale" || id == "rotor_position_error" || id == "rotor_axis_misalignment";
}

class SingleRotor final : public Effect {
 public:
  SingleRotor(const Effect& whole, int rotor)
      : whole_(whole),
        width_(whole.parameter_count() / kRotors),
        first_(rotor * width_),
        info_(whole.info()) {
    const auto from = whole.info().parameters.begin() + first_;
    info_.parameters.assign(from, from + width_);
    for (const physics::Parameter& p : whole.info().parameters) neutral_.push_back(p.neutral);
  }
  const physics::EffectInfo& info() const override { return info_; }
  bool acts_on_wrench() const override { return true; }
  bool linear_in_thrust() const override { return whole_.linear_in_thrust(); }
  void add_wrench(const physics::Situation& s, const double* theta, physics::Wrench& w) const override {
    whole_.add_wrench(s, all(theta).data(), w);
  }
  void wrench_with_jacobian(const physics::Situation& s, const double* theta, double* wrench,
                            double* jacobian) const override {
    std::array<double, 6 * physics::kMaxParameters> j{};
    whole_.wrench_with_jacobian(s, all(theta).data(), wrench, j.data());
    std::copy_n(j.begin() + 6 * first_, 6 * width_, jacobian);
  }

  const Effect& whole() const { return whole_; }
  std::vector<double> whole_theta(const std::vector<double>& theta) const {
    std::vector<double> out = neutral_;
    std::copy_n(theta.begin(), width_, out.begin() + first_);
    return out;
  }

 private:
  std::array<double, physics::kMaxParameters> all(const double* theta) const {
    std::array<double, physics::kMaxParameters> out{};
    std::copy(neutral_.begin(), neutral_.end(), out.begin());
    std::copy_n(theta, width_, out.begin() + first_);
    return out;
  }

  const Effect& whole_;
  int width_, first_;
  physics::EffectInfo info_;
  std::vector<double> neutral_;
};

/// One object for each effect and rotor, as long as the process lives: fits refer to effects by address.
const Effect& single_rotor(const Effect& whole, int rotor) {
  static std::mutex guard;
  static std::map<std::pair<const Effect*, int>, std::unique_ptr<const SingleRotor>> known;
  const std::lock_guard lock(guard);
  auto& one = known[{&whole, rotor}];
  if (!one) one = std::make_unique<const SingleRotor>(whole, rotor);
  return *one;
}

}  // namespace

std::vector<const Effect*> by_rotor(const std::vector<const Effect*>& candidates,
                                    const vehicle::Vehicle& vehicle) {
  std::vector<const Effect*> out;
  for (const Effect* effect : candidates) {
    if (is_by_rotor(*effect) && vehicle.rotor_count() > 1)
      for (int r = 0; r < std::min(kRotors, vehicle.rotor_count()); ++r)
        out.push_back(&single_rotor(*effect, r));
    else if (!is_by_rotor(*effect))
      out.push_back(effect);
    if (effect->info().id == "tilt_offset") out.push_back(&hidden_tilt_lag());
  }
  return out;
}

physics::ActiveEffect in_full(const physics::ActiveEffect& active) {
  if (active.effect == &hidden_tilt_lag())
    return {physics::find_effect("tilt_servo_lag"), {active.theta[0], 0.0}};
  const auto* one = dynamic_cast<const SingleRotor*>(active.effect);
  return one ? physics::ActiveEffect{&one->whole(), one->whole_theta(active.theta)} : active;
}

}  // namespace omniflight::diagnosis
