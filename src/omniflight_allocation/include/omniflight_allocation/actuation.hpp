// Which directions of force and torque a vehicle commands independently, over its whole range of tilt.
#pragma once

#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

enum class ActuationKind {
  omnidirectional,  ///< rank 6, and hovers in every attitude
  fully_actuated,   ///< rank 6: force and torque can be chosen independently, near some hover attitude
  underactuated,    ///< torque about every axis, force along one body axis only: it leans to accelerate
  restricted,       ///< torque about every axis, force in one plane only
  no_full_torque,   ///< no torque about some axis, or none without a force: hovering is not controlled
};
const char* to_string(ActuationKind kind);

/// At one tilt. Torques are about the centre of mass; forces are those that leave the torque zero.
struct ActuationAtTilt {
  double alpha = 0;  ///< rad
  ActuationKind kind = ActuationKind::no_full_torque;
  int rank = 0;                        ///< of the 6 x n allocation matrix
  int force_rank = 0;                  ///< dimension of the forces at zero torque
  Vec3 thrust_axis_B = Vec3::UnitZ();  ///< unit; points against gravity in the attitude of `hover_load`
  double hover_load = 0;               ///< share of the rotors' range that hovering needs in that attitude
  double thrust_to_weight = 0;         ///< largest force along the thrust axis at zero torque, over m g
  double lean = 0;                     ///< rad from that attitude; smaller ones hover in every direction
  bool hovers() const { return hover_load <= 1.0; }
  double reserve() const { return 1.0 - hover_load; }  ///< share of the rotors' range, negative: falls
};

/// A tilt at which the rank falls below that of the tilts about it.
struct SingularTilt {
  double alpha = 0;  ///< rad
  int rank = 0;      ///< there
  Vec6 lost_B =
      Vec6::Zero();  ///< unit direction of the wrench that is lost (torques over the longest lever arm)
  std::string lost;  ///< in words: "torque about z"
};

struct ActuationClass {
  std::vector<ActuationAtTilt> tilts;  ///< every degree and both limits; one for a vehicle that does not tilt
  bool individual = false;             ///< the rotors tilt one by one; what is told is that of a common tilt
  std::vector<SingularTilt> singular;  ///< in the order of the tilt
  /// Best hover over all tilts: the one with the largest thrust to weight ratio.
  const ActuationAtTilt& strongest() const;
  /// "fully actuated from 1 to 60 deg, omnidirectional from 42; singular at 7.6 deg (torque about z)".
  std::string words() const;
  /// " from 1 to 60 deg" of tilts `first` to `last`, " at 42 deg" of one; nothing for a vehicle that does not
  /// tilt.
  std::string range(std::size_t first, std::size_t last) const;
};

/// By the rank of the allocation matrix and by trim: the exact share of the rotors' ranges (RotorLoad) that
/// holds the weight at zero torque. The thrust axis is the only direction of force where there is one, else
/// the direction in which the vehicle lifts most among the body axes and the mean rotor axis. Refuses what
/// WrenchSet::create refuses.
Result<ActuationAtTilt> actuation_at(const vehicle::Vehicle& vehicle, double alpha);

/// Over the range of the tilt. Ranks are those of a common tilt of all rotors; singular tilts are minima of
/// the smallest singular value (Nakamura 1991, chapter 3) of the rank that nearly all tilts have, found to
/// 1e-9 rad.
Result<ActuationClass> classify_actuation(const vehicle::Vehicle& vehicle);

}  // namespace omniflight::allocation
