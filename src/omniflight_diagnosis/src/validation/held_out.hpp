// How well what was found predicts recordings, and parts of a recording, that it was not fitted to.
#pragma once

#include "../search/inference.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// RMS and share explained of body wrench and specific force [m/s^2], without and with the laws of a set, at
/// the values they were fitted to. What belongs to a recording is taken from it, with and without the laws:
/// calibration within its tolerances, and initial states of loads.
std::vector<ChannelFit> on_unseen_flights(const Inference& inference, const SetFit& set,
                                          const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle,
                                          const Options& options);

/// The same on thirds of a single flight, each predicted by the laws fitted to the other two.
std::vector<ChannelFit> on_thirds(const Inference& inference, const SetFit& set, const Flight& flight,
                                  const vehicle::Vehicle& vehicle, const Options& options);

}  // namespace omniflight::diagnosis
