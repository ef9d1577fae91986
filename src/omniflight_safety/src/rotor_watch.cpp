#include "omniflight_safety/rotor_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace omniflight::safety {
namespace {

constexpr double kTurns = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostRotors = 32;

bool finite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

RotorWatch::RotorWatch(const std::vector<WatchedRotor>& rotors, RotorWatchConfig config) : config_(config) {
  for (std::size_t i = 0; i < std::min(rotors.size(), kMostRotors); ++i) {
    max_speed_.push_back(rotors[i].max_speed);
    time_constant_.push_back(rotors[i].time_constant);
    patience_.push_back(config_.patience + rotors[i].time_constant +
                        (rotors[i].reverses ? config_.reversal : 0.0));
  }
  slow_since_.assign(max_speed_.size(), kTurns);
  expected_.assign(max_speed_.size(), 0.0);
}

bool RotorWatch::add(double t, std::span<const double> command, std::span<const double> measured) {
  if (command.size() != max_speed_.size() || measured.size() != max_speed_.size()) return false;
  if (!std::isfinite(t) || (begun_ && t <= last_) || !finite(command) || !finite(measured)) return false;
  const double passed = begun_ ? t - last_ : std::numeric_limits<double>::infinity();
  begun_ = true;
  last_ = t;
  const std::uint32_t before = lost_;
  for (std::size_t i = 0; i < max_speed_.size(); ++i) {
    const double share = time_constant_[i] > 0 ? -std::expm1(-passed / time_constant_[i]) : 1.0;
    expected_[i] += share * (command[i] - expected_[i]);
    const double due = std::abs(expected_[i]);
    const bool tells = due >= config_.commanded_share * max_speed_[i];
    if (!tells || std::abs(measured[i]) >= config_.reached_share * due) {
      slow_since_[i] = kTurns;
      continue;
    }
    if (std::isnan(slow_since_[i])) slow_since_[i] = t;
    if (t - slow_since_[i] > patience_[i]) lost_ |= std::uint32_t{1} << i;
  }
  return lost_ != before;
}

void RotorWatch::reset() {
  std::fill(slow_since_.begin(), slow_since_.end(), kTurns);
  std::fill(expected_.begin(), expected_.end(), 0.0);
  lost_ = 0;
  begun_ = false;
}

}  // namespace omniflight::safety
