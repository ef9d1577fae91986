// A rotor that answers a force looks like one that causes it, only later.
#pragma once

#include "fit.hpp"

namespace omniflight::diagnosis {

/// Feedback makes rotors push against whatever disturbs the body, a twentieth to an eighth of a second after
/// it: delay, filters and motor lag. A residual regressed on their thrust then says that thrust is weaker
/// than it is, whatever the disturbance was. True when effect `index`, a share of the rotors' thrust,
/// explains the residual better with its contribution moved ahead by such a time than where it stands or
/// moved back. Its mean has no say: rotors answer a constant force as well, and another law may make that.
bool answers_instead_of_causing(const Problem& problem, const Fit& fit, std::size_t index,
                                const Options& options);

}  // namespace omniflight::diagnosis
