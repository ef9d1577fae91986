// Which effects of the library explain the residual, and which cannot be told from them on this flight.
#pragma once

#include "alternatives.hpp"

namespace omniflight::diagnosis {

struct Naming {
  Fit null_model, model;
  std::vector<Named> named;  ///< parallel to model.effects
  std::vector<CandidateGain> candidates;
  AliasMatrix aliases;
  std::vector<std::string> left_out;  ///< what Options::stop cut short
};

Naming name_effects(const Problem& problem, const std::vector<const physics::Effect*>& candidates,
                    const Options& options);

}  // namespace omniflight::diagnosis
