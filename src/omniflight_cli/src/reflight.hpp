// Flies what a recording asked for once more, with nothing left out of the model: what a diagnosis finds
// there is what disturbances and feedback alone make it find.
#pragma once

#include "omniflight_diagnosis/options.hpp"
#include "omniflight_diagnosis/told.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::cli {

/// The nominal vehicle in closed loop in this process: reference and the thrusts that cancel each other from
/// the recording, gains and sensors as told, disturbances from the caller. Empty when the gains were not told
/// or the recording has no full reference or rotor commands; an underactuated vehicle has no such loop here.
diagnosis::Reflight make_reflight(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                                  const diagnosis::Told& told, const physics::Environment& environment);

}  // namespace omniflight::cli
