// The designs that chapter 5 compares, on one cube with one limit of the rotors.
#pragma once

#include "omniflight_reproduction/figure.hpp"

namespace omniflight::reproduction {

/// N, the limit on which the absolute figures of chapter 5 agree; Table 4.1 has 6.25 N.
inline constexpr double kChapter5Limit = 5.95;
inline constexpr double kTableMass = 1.595;  ///< kg, Table 4.1
/// rad, the tilt at which OmniMorph has the axes of the omnicopter: cos(alpha) = 1/sqrt(3).
double isotropic_tilt();
/// rad, the tilts at which the thesis compares sets.
std::vector<double> compared_tilts();

/// OmniMorph without drag torque: the sets of the thesis have none.
vehicle::Vehicle without_drag(vehicle::Vehicle v);
/// Choice 1 of section 5.2: the tilt axes turned back by 15 deg about body z, across the omnicopter's axes.
vehicle::Vehicle choice_1(const vehicle::Vehicle& omnimorph);
/// The omnicopter's axes on OmniMorph's cube with OmniMorph's rotors.
vehicle::Vehicle omnicopter_on_cube(const Inputs& inputs);

/// Seen from above and from the side: discs with their normals, and tilt axes across them [m].
report::Outlines drawing(const vehicle::Vehicle& v, double alpha, const std::string& title);

}  // namespace omniflight::reproduction
