#include "rotor_losses.hpp"

#include <cstdio>
#include <limits>

#include "omniflight_allocation/actuation.hpp"
#include "omniflight_allocation/rotor_load.hpp"

namespace omniflight::components {
namespace {

constexpr std::size_t kMostSamples = 256;  // half a second of the quickest telemetry

safety::RotorWatch watch_of(const vehicle::Vehicle& vehicle) {
  std::vector<safety::WatchedRotor> rotors;
  for (const vehicle::Rotor& r : vehicle.rotors)
    rotors.push_back({r.max_speed(), r.time_constant, r.bidirectional});
  return safety::RotorWatch(rotors);
}

}  // namespace

double hover_load_without(const vehicle::Vehicle& vehicle, std::uint32_t lost, double alpha,
                          const Quat& q_WB) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  vehicle::Vehicle rest = vehicle;
  rest.rotors.clear();
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i)
    if ((lost >> i & 1) == 0) rest.rotors.push_back(vehicle.rotors[i]);
  if (rest.rotors.empty()) return kNever;
  const auto kind = allocation::actuation_at(rest, alpha);
  if (!kind || kind->kind == allocation::ActuationKind::no_full_torque) return kNever;
  if (kind->rank < 6) return kind->hover_load;
  const auto rotors = allocation::RotorLoad::create(rest, alpha);
  return rotors ? rotors->hover_load(q_WB) : kNever;
}

RotorLosses::RotorLosses(const vehicle::Vehicle& vehicle) : vehicle_(vehicle), watch_(watch_of(vehicle)) {}

void RotorLosses::measured(double t, std::span<const double> speed) {
  const std::lock_guard lock(mutex_);
  if (samples_.size() == kMostSamples) samples_.pop_front();
  samples_.push_back({t, {speed.begin(), speed.end()}});
}

void RotorLosses::commanded(std::span<const double> speed, double alpha) {
  command_.assign(speed.begin(), speed.end());
  alpha_ = alpha;
}

void RotorLosses::gate(double t, bool passes) {
  const std::lock_guard lock(mutex_);
  if (passes == gate_passes_) return;
  gate_passes_ = passes;
  if (!passes)
    gate_closed_s_ = t;
  else if (t - gate_closed_s_ > kFaded)
    gate_passed_s_ = t;
}

bool RotorLosses::got_commands(double t) const {
  return t >= gate_passed_s_ && (gate_passes_ || t <= gate_closed_s_ + kFaded);
}

std::string RotorLosses::update(double now_s, double trajectory_time, const Quat& q_WR,
                                allocation::Allocator& allocator) {
  const bool moves = last_s_ >= 0 && trajectory_time > last_along_;
  if (moves) moving_s_ += std::max(0.0, now_s - last_s_);
  last_s_ = now_s;
  last_along_ = trajectory_time;
  const std::uint32_t before = watch_.lost();
  {
    const std::lock_guard lock(mutex_);
    for (; !samples_.empty() && samples_.front().t <= now_s - kLate; samples_.pop_front()) {
      if (!got_commands(samples_.front().t))
        watch_.interrupt();
      else if (moves && moving_s_ > kFlying && !winds_down_)
        watch_.add(samples_.front().t, command_, samples_.front().speed);
    }
  }
  const std::uint32_t fresh = watch_.lost() & ~before;
  return fresh == 0 ? std::string() : drop(fresh, q_WR, allocator);
}

std::string RotorLosses::drop(std::uint32_t fresh, const Quat& q_WR, allocation::Allocator& allocator) {
  std::string names;
  for (int i = 0; i < vehicle_.rotor_count(); ++i) {
    if ((fresh >> i & 1) == 0) continue;
    names += (names.empty() ? "" : ", ") + std::to_string(i + 1);
    (void)allocator.drop_rotor(i);  // the last one stays: without it hovering is refused below all the same
  }
  hover_load_ = hover_load_without(vehicle_, watch_.lost(), alpha_, q_WR);
  char rest[120];
  if (std::isfinite(hover_load_))
    std::snprintf(rest, sizeof rest, "the others need %.0f %% of their range to hover", 100.0 * hover_load_);
  else
    std::snprintf(rest, sizeof rest, "the others cannot hold the vehicle's attitude");
  return "rotor " + names + " does not turn as commanded and is left out; " + rest;
}

}  // namespace omniflight::components
