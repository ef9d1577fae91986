// Whether the rotors can give a motion at all: for vehicles whose allocation matrix has a rank below 6.
#pragma once

#include "omniflight_allocation/rotor_load.hpp"

namespace omniflight::planning {

/// Refuses knots whose wrench has a part outside the range of the allocation matrix. With a level attitude
/// slower flight scales that part with 1/duration^2 and never makes it zero: a quadrotor that is to stay
/// level cannot move sideways at any speed. A vehicle that leans into its motion (flatness.hpp) needs nothing
/// there.
Status check_actuation(const std::vector<TrajectoryKnot>& knots, const allocation::RotorLoad& rotors);

}  // namespace omniflight::planning
