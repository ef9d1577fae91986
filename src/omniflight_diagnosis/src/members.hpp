// The effects that a fit is made of: what they are to each other, and which of them may stay.
#pragma once

#include "costs.hpp"
#include "gate.hpp"

namespace omniflight::diagnosis {

/// Of a gain: what a law that is known in its outline only may lack.
inline constexpr double kLawKnown = 0.25;
/// Parameters of a law that is not rich.
inline constexpr int kFewNumbers = 3;
inline bool is_rich(const physics::Effect& effect) { return effect.parameter_count() > kFewNumbers; }

/// All but member `index`.
std::vector<physics::ActiveEffect> without(const std::vector<physics::ActiveEffect>& effects,
                                           std::size_t index);
bool contains(const Fit& fit, const physics::Effect* effect);
/// Whether a member that must gain `needed` stands on data it was not fitted to and is large enough to
/// matter. On instruments chance alone decides, and the gain already answers for that; blocks left out must
/// only not be predicted worse.
bool gate_open(const Problem& problem, const Gate& gate, const Options& o, double needed);
/// No amplitude at a limit, and not one of a pair that takes away what the other adds: it says little about
/// either.
bool makes_sense(const Problem& problem, const Fit& fit, std::size_t index);
/// Searches the shape parameters of every kept effect anew in the company of the others.
Fit polish(const Problem& problem, Fit fit, const Options& o);
/// The catalogue knows that these two may look alike: a cheap preview is not enough to tell them apart.
bool declared_alias(const physics::Effect& a, const physics::Effect& b);
/// An alias of member k that is the usual one beside another member: a cable pulls at a lever, as an offset
/// centre of mass does.
bool comes_with_another(const physics::Effect& effect, const Fit& fit, std::size_t k);
/// What a rich law with memory adds to one without of its kind, and to what comes with that, is what the
/// simple one lacks: a cable that hangs straight does not swing as a load does. `gains`: log-likelihood that
/// each member of the fit brings.
bool mends_another(const Fit& fit, std::size_t k, const std::vector<double>& gains);
/// It gives torques.
bool turns(const physics::Effect& effect);
/// The others of a fit exactly as they are, without member `index`: a replacement starts in unchanged
/// company.
Fit frozen_without(const Problem& problem, const Fit& fit, std::size_t index);
/// Removes effects that no longer earn their parameters.
Fit prune(const Problem& problem, Fit fit, const Options& o, const Costs& costs);

}  // namespace omniflight::diagnosis
