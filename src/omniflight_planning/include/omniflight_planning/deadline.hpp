// The moment at which planning gives up, looked at in every loop whose length the mission decides.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>

#include "omniflight_core/result.hpp"

namespace omniflight::planning {

/// Without an argument it never passes. Copies share the moment.
class Deadline {
 public:
  Deadline() = default;
  /// `stop` (may be null) ends the work before, once it is true.
  explicit Deadline(double seconds, bool (*stop)() = nullptr)
      : begin_(Clock::now()), limit_(seconds), stop_(stop) {}

  /// The same, but no later than `seconds` from now.
  Deadline within(double seconds) const { return Deadline(std::min(seconds, left()), stop_); }

  double limit() const { return limit_; }  ///< s, from its construction
  double left() const {                    ///< s; negative once it has passed
    return limit_ - std::chrono::duration<double>(Clock::now() - begin_).count();
  }
  bool stopped() const { return stop_ != nullptr && stop_(); }
  bool passed() const { return stopped() || (limit_ < kNever && left() <= 0.0); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  Clock::time_point begin_ = {};
  double limit_ = kNever;
  bool (*stop_)() = nullptr;
};

/// The error of a plan that is not finished in time; `phase` is what it was at.
Failure out_of_time(const Deadline& deadline, const std::string& phase);

}  // namespace omniflight::planning
