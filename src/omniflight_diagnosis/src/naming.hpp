// Which effects of the library explain the residual, and which cannot be told from them on this flight.
#pragma once

#include "alternatives.hpp"

namespace omniflight::diagnosis {

struct Naming {
  Fit null_model, model;
  std::vector<CandidateGain> candidates;
  AloneFits alone;
  std::vector<const physics::Effect*> asked;  ///< the candidates, in order
  std::vector<std::string> left_out;          ///< what Options::stop cut short

  // from tell_rivals()
  std::vector<Named> named;  ///< parallel to model.effects
  AliasMatrix aliases;
};

/// The model that explains most for its numbers. `before`: of much the same flight, where bends were that
/// need not be searched for far away again.
Naming name_effects(const Problem& problem, const std::vector<const physics::Effect*>& candidates,
                    const Options& options, const Naming* before = nullptr);

/// What else each member could have been, and how well the candidates imitate each other. Searches the bends
/// of the model's laws once more around their own first, which can move them.
void tell_rivals(const Problem& problem, const Options& options, Naming& naming);

}  // namespace omniflight::diagnosis
