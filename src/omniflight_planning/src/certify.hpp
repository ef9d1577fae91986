// What a finished curve must keep, checked before there is a plan.
#pragma once

#include "omniflight_planning/plan.hpp"
#include "ride_leg.hpp"
#include "tilts.hpp"

namespace omniflight::planning {

/// Checks the finished curve, every piece at its own tilt, and fills in what the certificate says of it.
/// headroom: share of the rotors' range and of their rate of thrust that stays free.
Status certify(const Trajectory& trajectory, const vehicle::Vehicle& vehicle, Tilts& tilts, double headroom,
               const Deadline& deadline, Certificate& c);

/// Limits of the tether that poses do not show, and the rotors when it carries itself.
Status certify_tether(const Mission& mission, const vehicle::Vehicle& without_tether, const Knots& all,
                      Certificate& c);

}  // namespace omniflight::planning
