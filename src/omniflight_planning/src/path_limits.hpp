// What the limits leave of speed and acceleration at each place of a curve, and the fastest profile within.
#pragma once

#include "omniflight_planning/time_optimal.hpp"
#include "polygon.hpp"

namespace omniflight::planning {

class PathLimits {
 public:
  /// At `steps` + 1 places at equal distances of the curve's parameter. Fails as time_optimal() does.
  static Result<PathLimits> create(const PoseCurve& curve, const allocation::RotorLoad& rotors,
                                   const MotionLimits& limits, int steps, const Deadline& deadline);
  /// At as many places as there are rotors, each with its own, and with its own bound of the speed along the
  /// curve [m/s].
  static Result<PathLimits> create(const PoseCurve& curve,
                                   const std::vector<const allocation::RotorLoad*>& rotors,
                                   const std::vector<double>& speeds, const MotionLimits& limits,
                                   const Deadline& deadline);

  int steps() const { return static_cast<int>(allowed_.size()) - 1; }
  /// The fastest profile; of each place's speeds (squared) and accelerations only a share (0, 1] is used.
  Result<SpeedProfile> fastest(const std::vector<double>& shares) const;

 private:
  explicit PathLimits(double length) : length_(length) {}

  double length_;  // m
  std::vector<Polygon> allowed_;
};

}  // namespace omniflight::planning
