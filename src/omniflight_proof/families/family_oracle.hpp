// What could be told apart at all: generalised least squares that is told the noise, the calibration and what
// is hidden, on the flight without noise.
#pragma once

#include "family_draw.hpp"
#include "family_laboratory.hpp"
#include "hidden.hpp"

namespace omniflight::proof {

/// flown: the hidden effect alone, with its series; turbulence: N, N m RMS. Singles are judged where what is
/// hidden shows in the wrench or in the thrusts of the commands; of sensor errors it says nothing.
Separability ask_oracle(const FamilyPlan& plan, const Laboratory& laboratory,
                        const std::array<double, 6>& turbulence, const FamilyFlown& flown);

}  // namespace omniflight::proof
