// What a motion or an attitude asks of the rotors at one tilt: for planners.
#pragma once

#include "omniflight_allocation/wrench_set.hpp"
#include "omniflight_core/trajectory.hpp"

namespace omniflight::allocation {

/// Constant after construction, safe from several threads. A wrench is force [N] then torque [Nm] about the
/// body origin, body axes; a load is WrenchSet::load: 1 is the limit, infinite means that no thrusts do it.
class RotorLoad {
 public:
  /// Refuses what WrenchSet::create refuses.
  static Result<RotorLoad> create(const vehicle::Vehicle& vehicle, double alpha);

  double load(const Vec6& wrench_B) const;
  /// Wrench that the rotors must give for a motion of the body origin, gravity and the centre of mass
  /// included.
  Vec6 required_wrench(const Reference& motion) const;
  double motion_load(const Reference& motion) const { return load(required_wrench(motion)); }
  /// Load of hovering at an attitude.
  double hover_load(const Quat& q_WB) const;
  /// The most that hover_load changes by for each radian between two attitudes; infinite where not every
  /// wrench can be given.
  double hover_slope() const { return hover_slope_; }

  /// What a motion asks of directions in which the rotors give nothing, and how much it needs beyond hovering
  /// at the same attitude; with a fixed path and a level attitude both scale with 1/duration^2.
  struct Inertial {
    Vec6 unreachable_B;  ///< N, part of the whole wrench that no thrusts give (torques divided by a lever
                         ///< arm, about the centre of mass)
    double size = 0;     ///< N, norm of what is needed beyond hovering
  };
  Inertial inertial_wrench(const Reference& motion) const;

  double alpha() const { return alpha_; }  ///< rad
  int rank() const {
    return wrenches_.rank();
  }  ///< of the allocation matrix; 6 = any small wrench is possible

 private:
  RotorLoad(WrenchSet wrenches, const vehicle::Vehicle& vehicle, double alpha);

  WrenchSet wrenches_;
  double alpha_, mass_, hover_slope_;
  Mat3 inertia_;
  Vec3 p_BBcm_;
};

}  // namespace omniflight::allocation
