// The tilt of the rotors along a curve on which it moves.
#pragma once

#include <memory>
#include <vector>

#include "omniflight_planning/timing.hpp"

namespace omniflight::planning {

/// Tilt over the parameter of a curve: a natural cubic spline, twice continuously differentiable.
class TiltWay {
 public:
  /// tilts: rad, at equal distances of the parameter from 0 to `length` [m], at least two.
  TiltWay(std::vector<double> tilts, double length);
  double at(double u) const;  ///< rad

 private:
  double step_;
  std::vector<double> value_, curvature_;
};

/// Tilts [rad] from one to another, a degree apart at most, and the rotors at each.
struct TiltRange {
  std::vector<double> tilts;
  std::vector<std::shared_ptr<const Rotors>> rotors;
};

/// Ways from the first tilt of the range to the last, the simplest first: in proportion to the parameter, and
/// the one of least change (sum of squares) through tilts at which the rotors hold the attitude of each place
/// with the headroom. The second is absent where there is none.
std::vector<TiltWay> tilt_ways(const PoseCurve& curve, const TiltRange& range, double headroom);

}  // namespace omniflight::planning
