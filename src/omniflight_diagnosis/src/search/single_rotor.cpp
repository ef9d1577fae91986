#include "single_rotor.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>

namespace omniflight::diagnosis {
namespace {

using physics::Effect;

class SingleRotor final : public Effect {
 public:
  SingleRotor(const Effect& whole, int rotor)
      : whole_(whole),
        width_(whole.info().parameters_per_rotor),
        first_(rotor * width_),
        info_(whole.info()) {
    const auto from = whole.info().parameters.begin() + first_;
    info_.parameters.assign(from, from + width_);
    info_.parameters_per_rotor = 0;
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

/// Forms that act on the wrench, of effects that look most like this one.
void add_unrecorded_forms(const std::string& beside, std::vector<const Effect*>& out) {
  for (const Effect* effect : physics::builtin_effects()) {
    const std::vector<std::string>& aliases = effect->info().aliases;
    const Effect* form = effect->unrecorded_form();
    if (form && !aliases.empty() && aliases.front() == beside) out.push_back(form);
  }
}

}  // namespace

std::vector<const Effect*> by_rotor(const std::vector<const Effect*>& candidates,
                                    const vehicle::Vehicle& vehicle) {
  std::vector<const Effect*> out;
  for (const Effect* effect : candidates) {
    const int each = effect->info().parameters_per_rotor;
    if (each == 0)
      out.push_back(effect);
    else if (vehicle.rotor_count() > 1)
      for (int r = 0; r < std::min(effect->parameter_count() / each, vehicle.rotor_count()); ++r)
        out.push_back(&single_rotor(*effect, r));
    add_unrecorded_forms(effect->info().id, out);
  }
  return out;
}

physics::ActiveEffect in_full(const physics::ActiveEffect& active) {
  if (const auto* one = dynamic_cast<const SingleRotor*>(active.effect))
    return {&one->whole(), one->whole_theta(active.theta)};
  const Effect* listed = physics::find_effect(active.effect->info().id);
  if (listed && listed->unrecorded_form() == active.effect)
    return {listed, listed->from_unrecorded_form(active.theta)};
  return active;
}

}  // namespace omniflight::diagnosis
