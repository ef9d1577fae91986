// From squared rotor speeds to a wrench, at any tilt: the nominal law, and every effect that is linear in the
// thrusts.
#pragma once

#include <span>

#include "omniflight_physics/effect.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::simulation {

class ThrustMap {
 public:
  /// Force [N] and torque [Nm] about the body origin, body axes, per squared speed [(rad/s)^2] of a rotor,
  /// one column each; the square is signed where the rotor reverses.
  using Columns = Eigen::Matrix<double, 6, vehicle::kMaxRotors>;

  ThrustMap() = default;
  /// Asks the effects themselves (those that are Effect::linear_in_thrust; others are passed over).
  ThrustMap(const vehicle::Vehicle& vehicle, std::span<const physics::ActiveEffect> effects);

  /// The map at a tilt [rad].
  Columns at(double alpha) const;
  /// What at() adds up: [0] + [1] cos(alpha) + [2] sin(alpha), and `sloped` of these times alpha.
  const Columns& part(int k, bool sloped = false) const { return sloped ? sloped_[k] : part_[k]; }

 private:
  Columns part_[3], sloped_[3];
  bool slopes_ = false;  ///< sloped_ is not zero
};

}  // namespace omniflight::simulation
