// The loop closed again along the reference that a recording holds, without and with the model found.
#pragma once

#include <string>

#include "omniflight_core/result.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_diagnosis/prior_knowledge.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::cli {

/// Fills closed_loop (RMSE of position [m] and attitude [deg] a axis: recorded, nominal, with the model) and
/// power [W, mechanical] of d.fit. The told controller flies the recorded reference, tilt and null-space
/// thrusts in the simulator, under turbulence as strong as told; with the model also the gains that were
/// found to be flown (d.controller). Errors: bad_input naming the signal or key that is missing; incomplete
/// when the model cannot be flown at all.
Status refly_recorded(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                      const diagnosis::PriorKnowledge& told, const diagnosis::Options& options,
                      diagnosis::Diagnosis& d);

}  // namespace omniflight::cli
