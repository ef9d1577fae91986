// Where the vehicle was asked to be, as far as no disturbance has moved it.
#pragma once

#include <vector>

#include "grid.hpp"
#include "omniflight_diagnosis/options.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Whether the rotor axes, at the recorded tilts, are not all parallel, so that attitude and position are
/// controlled independently. True where the rotors tilt and the tilt is not recorded.
bool attitude_is_free(const vehicle::Vehicle& vehicle,
                      const std::vector<const recording::Recording*>& recordings);

/// Flight::reference on the fine grid. The attitude of a vehicle whose rotors are parallel is not taken from
/// the recording, where it may be what a position loop asks for against a disturbance: it follows from the
/// acceleration and the heading of the reference (Mellinger and Kumar 2011).
Eigen::MatrixXd reference_motion(const recording::Recording& recording, const Grid& grid,
                                 const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
