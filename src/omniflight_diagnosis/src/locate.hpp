// Where the wrench of model and flight differ: channel, time, place; without any hypothesis from the library.
#pragma once

#include "fit.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Mismatch of the wrench stage. `before` is the residual of the nominal model (offsets within tolerance
/// removed), `after` what remains of the best model. Vertical force is reported in the world frame.
std::vector<Mismatch> locate_wrench(const Problem& problem, const Fit& before, const Fit& after,
                                    std::span<const Flight* const> flights, const Options& options);

/// What is still predictable from the vehicle's own state after the model, and is large.
std::vector<Unexplained> locate_unexplained(const Problem& problem, const Fit& after, const Options& options);

/// Allocation (desired against allocated acceleration) and tracking of one recording, where logged.
std::vector<Mismatch> locate_allocation(const recording::Recording& recording);

}  // namespace omniflight::diagnosis
