// Which effects of the library explain the residual, and which cannot be told from them on this flight.
#pragma once

#include "gate.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

struct Alternative {
  std::string effect;
  std::vector<double> theta;         ///< the values it would take
  double log_likelihood_behind = 0;  ///< of the best set, penalties included; may be slightly negative
  double cosine = 0;                 ///< of the whitened contributions
};

struct Named {
  double probability = 1;
  double gain = 0;  ///< log-likelihood lost when the effect is left out
  Gate gate;
  std::vector<Alternative> set;    ///< what cannot be told apart from it
  std::vector<Alternative> alike;  ///< tells a little worse, but looks the same (whitened cosine > 0.98)
  double swapped_best = -1e18;     ///< of all other swaps, relative to the chosen set
};

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
