// Through a narrow place: poses that fit it, and motions out of it to both sides.
#pragma once

#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_planning/deadline.hpp"
#include "omniflight_planning/state_check.hpp"
#include "passages.hpp"

namespace omniflight::planning {

struct Gap {
  Vec3 p_W = Vec3::Zero();       ///< the narrowest place
  double distance = 0.0;         ///< m, of the nearest obstacle there
  Vec3 along_W = Vec3::UnitX();  ///< unit, the way through
};

/// The narrow places of a way: where it is narrower than `wide` [m] and wider before and after.
std::vector<Gap> gaps_of(const std::vector<WayPlace>& way, double wide);

struct Crossing {
  std::vector<Pose> poses;  ///< from one side to the other, neighbours joined by free motions; empty: none
  double lack = 0.0;        ///< m, that the best pose in the gap misses of the margin; where nothing fits
  bool unholdable = false;  ///< a pose fits, at an attitude that the rotors cannot hold
};

/// Fits the vehicle into a gap: of many attitudes (those of start and goal, frames of the gap, random ones)
/// the best are improved by random steps across the gap, first the sum of squares by which the spheres miss
/// the margin, then the room. From the best pose it crawls to both sides, re-centred at every step, until
/// there is room for any attitude.
Crossing cross(const StateCheck& check, const Gap& gap, const std::vector<Quat>& attitudes, Random& random,
               const Deadline& deadline);

}  // namespace omniflight::planning
