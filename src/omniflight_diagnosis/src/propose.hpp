// The next flight: which manoeuvre would tell apart what this flight could not.
#pragma once

#include "naming.hpp"

namespace omniflight::diagnosis {

/// Two explanations that fit alike: the named one as fitted, the other with the values it would take.
struct Rivals {
  physics::ActiveEffect named, other;
};

/// What is to be told apart of member k: it from everything in its set, and these from each other, because
/// any of them may be true.
std::vector<Rivals> rivals_of(const Naming& naming, std::size_t k);

/// Manoeuvres of the catalogue, the one that tells most pairs apart first. The
/// separation [sigma] is the length of what `other` (and the offsets) cannot imitate of `named` on the old
/// and the new flight together, under the noise of the old one. An `other` that contains `named` is told
/// apart by its further numbers instead.
std::vector<ProposedFlight> propose_flights(const Problem& flown, const Flight& flight,
                                            const vehicle::Vehicle& vehicle, const std::vector<Rivals>& pairs,
                                            const Options& options);

}  // namespace omniflight::diagnosis
