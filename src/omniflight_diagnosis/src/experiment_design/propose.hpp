// The next flight: which manoeuvre would tell apart what this flight could not.
#pragma once

#include "../evidence/noise_model.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Two explanations that fit alike: the named one as fitted, the other with the values it would take.
struct Rivals {
  physics::ActiveEffect named, other;
};

/// Manoeuvres of the catalogue, the one that tells most pairs apart first. The separation [sigma] is the
/// length of what `other`, the calibration and initial states of loads cannot imitate of `named` on the old
/// and the new flight together, under the noise of the old one (its first flight). An `other` that contains
/// `named` is told apart by its further numbers instead.
std::vector<ProposedFlight> propose_flights(const RegressionProblem& flown, const NoiseModel& noise,
                                            const Flight& flight, const vehicle::Vehicle& vehicle,
                                            const std::vector<Rivals>& pairs, const Options& options);

}  // namespace omniflight::diagnosis
