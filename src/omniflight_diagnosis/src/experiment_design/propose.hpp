// Experiment design: manoeuvres that would separate rival effects.
#pragma once

#include "../evidence/noise_model.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Two effects that fit the flight equally well, each at its estimate.
struct Rivals {
  physics::ActiveEffect named, other;
};

/// Manoeuvres of the catalogue, ranked by the number of pairs that they separate, with predicted separations.
/// The separation [sigma] is the whitened norm of the part of `named` that `other`, calibration and initial
/// states cannot imitate on the flown and the new flight together, under the noise of the first flown flight.
/// An `other` that contains `named` as a special case is separated by its additional parameters instead.
/// Empty without pairs or samples.
std::vector<ProposedFlight> propose_flights(const RegressionProblem& flown, const NoiseModel& noise,
                                            const Flight& flight, const vehicle::Vehicle& vehicle,
                                            const std::vector<Rivals>& pairs, const Options& options);

}  // namespace omniflight::diagnosis
