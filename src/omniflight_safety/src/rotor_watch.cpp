#include "omniflight_safety/rotor_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace omniflight::safety {
namespace {

constexpr double kTurns = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostRotors = 32;

bool finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

RotorWatch::RotorWatch(const std::vector<WatchedRotor>& rotors, RotorWatchConfig config)
    : config_(config),
      rotors_(rotors.begin(),
              rotors.begin() + static_cast<std::ptrdiff_t>(std::min(rotors.size(), kMostRotors))) {
  reset();
}

bool RotorWatch::could_be_reversing(std::size_t i) const {
  return rotors_[i].reverses &&
         slow_since_[i] - reversed_at_[i] <= config_.reversal + rotors_[i].time_constant;
}

bool RotorWatch::add(double t, std::span<const double> command, std::span<const double> measured) {
  if (command.size() != rotors_.size() || measured.size() != rotors_.size()) return false;
  if (!std::isfinite(t) || (begun_ && t <= last_) || !finite(command) || !finite(measured)) return false;
  const bool first = !std::exchange(begun_, true);
  const double passed = t - std::exchange(last_, t);
  const std::uint32_t before = lost_;
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    const double lag = rotors_[i].time_constant, was = expected_[i];
    expected_[i] += (first || lag <= 0 ? 1.0 : -std::expm1(-passed / lag)) * (command[i] - was);
    if (first || was * expected_[i] < 0) reversed_at_[i] = t;
    const double due = std::abs(expected_[i]);
    const bool tells = due >= config_.commanded_share * rotors_[i].max_speed;
    if (!tells || std::abs(measured[i]) >= config_.reached_share * due) {
      slow_since_[i] = kTurns;
      continue;
    }
    if (std::isnan(slow_since_[i])) slow_since_[i] = t;
    const double patience = config_.patience + lag + (could_be_reversing(i) ? config_.reversal : 0.0);
    if (t - slow_since_[i] > patience) lost_ |= std::uint32_t{1} << i;
  }
  return lost_ != before;
}

void RotorWatch::interrupt() {
  slow_since_.assign(rotors_.size(), kTurns);
  expected_.assign(rotors_.size(), 0.0);
  reversed_at_.assign(rotors_.size(), 0.0);
  begun_ = false;
}

void RotorWatch::reset() {
  interrupt();
  lost_ = 0;
}

}  // namespace omniflight::safety
