// Cross-validation: prediction of recordings, or parts of one, that were not fitted.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// RMS and coefficient of determination of wrench [N, Nm, body] and specific force [m/s^2], without and with
/// the laws of a set at the fitted parameters. Calibration (within its tolerances) and initial states of
/// loads are specific to a recording and therefore estimated from each, both without and with the laws.
/// Unknown physics is not predicted.
std::vector<ChannelFit> on_unseen_flights(const Inference& inference, const SetFit& set,
                                          const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle,
                                          const Options& options);

/// The same for each third of a single flight, predicted by the laws refitted to the other two; thirds, or
/// rests, with less than 3 s of usable samples are skipped.
std::vector<ChannelFit> on_thirds(const Inference& inference, const SetFit& set, const Flight& flight,
                                  const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
