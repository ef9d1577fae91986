// Which wrenches the rotors can give at one tilt: the exact zonotope of the allocation matrix as half-spaces.
#pragma once

#include <functional>
#include <memory>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

/// Constant after construction. A wrench is force [N] then torque [Nm] about the body origin, body axes.
class WrenchLimits {
 public:
  WrenchLimits(const vehicle::Vehicle& vehicle, double alpha);

  /// Share of the rotors' range that the best allocation of a wrench needs: the least over all allocations of
  /// max |u_i - middle_i| / half range_i. 1 is the limit; infinite when no thrusts of any size give the
  /// wrench.
  double load(const Vec6& wrench_B) const;

  /// Wrench that the rotors must give for a motion of the body origin, gravity and the centre of mass
  /// included.
  Vec6 required_wrench(const Reference& motion) const;
  double motion_load(const Reference& motion) const { return load(required_wrench(motion)); }
  /// Load of hovering at an attitude.
  double hover_load(const Quat& q_WB) const;

  double alpha() const { return alpha_; }  ///< rad
  int rank() const { return rank_; }       ///< of the allocation matrix; 6 = any small wrench is possible

 private:
  double alpha_ = 0.0, mass_ = 0.0;
  int rank_ = 0;
  Mat3 inertia_;
  Vec3 p_BBcm_;
  Vec6 middle_;                                      // wrench of the middle of all thrust ranges
  Eigen::Matrix<double, Eigen::Dynamic, 6> facets_;  // load = max |facets (wrench - middle)|
  Mat6 outside_;                                     // part of a wrench that no rotor can give
};

/// Whether the vehicle can hover at an attitude and tilt [rad].
using HoverCheck = std::function<bool(const Quat& q_WB, double alpha)>;

/// Exact check with the share `headroom` in [0, 1) of every rotor's range kept free.
HoverCheck hover_check(const vehicle::Vehicle& vehicle, double headroom);

}  // namespace omniflight::planning
