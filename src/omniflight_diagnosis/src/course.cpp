#include "course.hpp"

#include <algorithm>
#include <cmath>

#include "bursts.hpp"
#include "confirmed.hpp"
#include "ground_law.hpp"
#include "improvement.hpp"
#include "instruments.hpp"
#include "offered.hpp"
#include "single_rotor.hpp"

namespace omniflight::diagnosis {

using physics::Effect;

std::vector<const Flight*> pointers(const std::vector<Flight>& flights) {
  std::vector<const Flight*> out;
  for (const Flight& f : flights) out.push_back(&f);
  return out;
}

Course::Course(const std::vector<Flight>& flights, const vehicle::Vehicle& vehicle, const Options& o,
               std::vector<Input>& inputs)
    : flights_(flights), vehicle_(vehicle), o_(o), inputs_(inputs) {
  // a flight whose rotor speeds lie says nothing about the wrench
  for (const Flight& f : flights)
    if (std::none_of(f.faults.begin(), f.faults.end(),
                     [](const SensorFault& fault) { return fault.effect == "rotor_speed_sensor_fault"; }))
      recorded_.push_back(&f);
  blind_ = recorded_.empty();
  if (blind_) recorded_ = pointers(flights);
  used_ = recorded_;
  all_ = std::make_unique<const Problem>(used_, vehicle, o);
  if (!blind_) candidates_ = offered_effects(used_, vehicle, o);
  hypotheses_ = with_single_rotors(candidates_, vehicle);
}

/// What a model's effects do to the body in every flight [N, Nm], a row a sample; held where nothing is
/// known.
std::vector<Eigen::MatrixXd> Course::wrench_of(const Fit& model) const {
  Eigen::VectorXd without, with;
  all_->predict({}, model.offsets, without, nullptr);
  all_->predict(model.effects, model.offsets, with, nullptr);
  const Eigen::VectorXd own = without - with;
  const int n = all_->samples();
  std::vector<Eigen::MatrixXd> out;
  int row = 0;
  for (const Flight* flight : used_) {
    Eigen::MatrixXd& w = out.emplace_back(Eigen::MatrixXd::Zero(flight->size(), 6));
    int filled = 0;
    for (const Segment& s : flight->segments)
      for (int i = s.begin; i < s.end; ++i, ++row) {
        for (int c = 0; c < 6; ++c) w(i, c) = own[c * n + row];
        for (; filled < i; ++filled) w.row(filled) = filled > 0 ? w.row(filled - 1).eval() : w.row(i);
        ++filled;
      }
    for (; filled > 0 && filled < flight->size(); ++filled) w.row(filled) = w.row(filled - 1);
  }
  return out;
}

/// Under the wrench of what is known, so that effects are judged free of feedback.
bool Course::fly_again(const std::vector<Eigen::MatrixXd>& known) {
  if (blind_ || o_.refly.size() != flights_.size()) return false;
  std::vector<Flight> found;
  for (std::size_t k = 0; k < recorded_.size(); ++k) {
    const auto which = static_cast<std::size_t>(recorded_[k] - flights_.data());
    auto one = with_instruments(*recorded_[k], known[k], motors_, vehicle_, o_, o_.refly[which]);
    if (!one) return false;
    if (steady_) leave_out_reversals(*one);
    inputs_[which].excluded = one->excluded;
    found.push_back(std::move(*one));
  }
  freed_ = std::move(found);
  used_ = pointers(freed_);
  all_ = std::make_unique<const Problem>(used_, vehicle_, o_);
  return true;
}

/// From a flight again that knows of nothing, then from one that knows of what was found.
bool Course::start_over() {
  std::vector<Eigen::MatrixXd> nothing;
  for (const Flight* f : recorded_) nothing.emplace_back(Eigen::MatrixXd::Zero(f->size(), 6));
  const bool freed = fly_again(nothing);
  naming_ = name_effects(*all_, hypotheses_, o_);
  return freed;
}

/// Of rotors that reverse all the time the flight again repeats no reversal at its moment, and what that
/// leaves looks like an inertia error or rotors out of place. Names that are worth nothing without those
/// samples were made of them: then they are left out, which costs half of a flight that rocks quickly.
void Course::judge_between_reversals() {
  std::vector<Flight> between = freed_;
  bool shorter = false;
  for (Flight& f : between) shorter = leave_out_reversals(f) || shorter;
  if (!shorter || naming_.model.effects.empty()) return;
  const Problem problem(pointers(between), vehicle_, o_);
  if (unconfirmed(problem, naming_.model, hypotheses_.size(), o_, 0).empty()) return;
  steady_ = true;
  if (start_over() && !o_.stopped() && fly_again_with_names())
    naming_ = name_effects(*all_, hypotheses_, o_, &naming_);
  take_measured();
}

void Course::take_measured() {
  std::vector<Flight> seen = calm_ ? calm_flights_ : freed_;
  for (Flight& f : seen) f.instrument = f.smooth;
  measured_ = std::make_unique<const Problem>(pointers(seen), vehicle_, o_);
}

const Effect* Course::not_shown(bool bent) const {
  std::vector<const Effect*> asked;
  for (const Effect* e : hypotheses_)
    if (acts_at_once(*e) && is_linear(*e) != bent) asked.push_back(e);
  return measured_ && !o_.stopped() ? overlooked(*measured_, naming_.model, asked, o_) : nullptr;
}

/// What comes and goes from outside must not be bent into an effect of the vehicle's own state.
void Course::cut_bursts() {
  const Eigen::VectorXd& before = naming_.null_model.residual;
  const std::vector<Burst> bursts = blind_ ? std::vector<Burst>{} : find_bursts(*all_, before);
  const auto cut = [&](const Burst& b) {  // what the floor does stays in
    return !(grounded_ && b.force.z() > 0 && is_low(all_->situation(0), b.place.z()));
  };
  if (std::none_of(bursts.begin(), bursts.end(), cut) ||
      explained_in_bursts(*all_, before, naming_.model.residual, bursts) >= 0.7)
    return;
  for (std::size_t k = 0; k < used_.size(); ++k) {
    calm_flights_.push_back(*used_[k]);
    for (const Burst& b : bursts)
      if (b.flight == static_cast<int>(k) && cut(b))
        calm_flights_.back() = part_of(calm_flights_.back(), b.from_s - 0.5, b.to_s + 0.5, false);
  }
  calm_ = std::make_unique<const Problem>(pointers(calm_flights_), vehicle_, o_);
  if (calm_->samples() < 4 * o_.grid_hz)
    calm_.reset();
  else
    naming_ = name_effects(*calm_, hypotheses_, o_);
}

/// Only what earns its numbers on the measured flight, too.
void Course::confirm() {
  constexpr int kRounds = 3;
  take_measured();
  auto left = hypotheses_;
  for (int round = 0; round < kRounds && !o_.stopped(); ++round) {
    const auto refused = unconfirmed(*measured_, naming_.model, hypotheses_.size(), o_);
    if (refused.empty()) return;
    std::erase_if(left, [&](const Effect* e) {
      return std::find(refused.begin(), refused.end(), e->info().id) != refused.end();
    });
    naming_ = name_effects(problem(), left, o_, &naming_);
    // the instruments were flown under the wrench of what is refused now
    if (!calm_ && fly_again_with_names()) {
      take_measured();
      naming_ = name_effects(*all_, left, o_, &naming_);
    }
  }
}

const Effect* Course::name(const std::vector<physics::ActiveEffect>& motors) {
  motors_ = motors;
  const bool freed = start_over();
  if (freed) take_measured();
  if (const Effect* effect = not_shown(true)) return effect;
  // once more with what was found, since a load moves the working point of the rotors
  if (freed && !o_.stopped() && fly_again_with_names())
    naming_ = name_effects(*all_, hypotheses_, o_, &naming_);
  if (freed && !o_.stopped()) judge_between_reversals();
  const bool offered = std::any_of(candidates_.begin(), candidates_.end(),
                                   [](const Effect* e) { return e->info().id == "ground_effect"; });
  const double per_parameter =
      std::log(std::max(2.0, static_cast<double>(candidates_.size())) / o_.error_rate);
  grounded_ = offered && !blind_ && follows_ground_law(*all_, per_parameter, o_);
  cut_bursts();
  if (freed) confirm();
  if (const Effect* effect = not_shown(false)) return effect;
  tell_rivals(problem(), o_, naming_);
  if (grounded_) add_ground_law(problem(), per_parameter, o_, naming_);
  return nullptr;
}

}  // namespace omniflight::diagnosis
