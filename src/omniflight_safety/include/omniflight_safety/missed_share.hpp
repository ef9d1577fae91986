// The share of control periods that a clock master misses, from the times of its ticks alone.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace omniflight::safety {

/// Over the last second, in tenths of it. Time is an argument; a clock that runs back starts anew.
class MissedShare {
 public:
  /// A tick at t [s] of a clock master that wants one every period [s].
  void tick(double t, double period) {
    if (!std::isfinite(t) || !(period > 0)) return;
    const auto tenth = static_cast<long long>(std::floor(10.0 * t));
    if (!begun_ || t <= last_s_) {
      *this = MissedShare{};
    } else {
      const double whole = std::max(0.0, std::floor((t - last_s_) / period * kRounding) - 1.0);
      for (long long k = std::max(tenth_, tenth - kTenths); k < tenth; ++k) {
        at_ = (at_ + 1) % periods_.size();
        periods_[at_] = missed_[at_] = 0;
      }
      periods_[at_] += 1.0 + whole;
      missed_[at_] += whole;
    }
    begun_ = true;
    tenth_ = tenth;
    last_s_ = t;
  }
  /// 0 to 1; 0 before anything is known.
  double share() const {
    double periods = 0, missed = 0;
    for (std::size_t k = 0; k < periods_.size(); ++k) {
      periods += periods_[k];
      missed += missed_[k];
    }
    return periods > 0 ? missed / periods : 0.0;
  }

 private:
  static constexpr int kTenths = 10;
  static constexpr double kRounding = 1.0 + 1e-6;  // two periods that are short of two by rounding are two
  std::array<double, kTenths> periods_{}, missed_{};
  std::size_t at_ = 0;  ///< the tenth that is filled
  long long tenth_ = 0;
  double last_s_ = 0;
  bool begun_ = false;
};

}  // namespace omniflight::safety
