// What an operator states beside a recording: told.yaml. Every key is optional.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "omniflight_diagnosis/options.hpp"

namespace omniflight::diagnosis {

struct PriorKnowledge {
  std::string file;
  /// Numbers by their place in the file: "sensors.accelerometer.noise_rms_mps2" (one or three numbers).
  std::map<std::string, std::vector<double>> numbers;
  std::vector<std::string> neighbours;  ///< recordings of other vehicles, paths made relative to the file
  std::vector<std::string> ignored;     ///< places that mean nothing to a diagnosis
};

/// Errors: bad_input naming file, line and field of a value that is no number or out of range.
Result<PriorKnowledge> load_prior_knowledge(const std::string& path);

/// The told file beside a recording: <recording>.told.yaml, or told.yaml in its folder; empty when there is
/// none.
std::string prior_knowledge_beside(const std::string& recording);

/// Environment, tolerances and controller as told; the neighbours' tracks are set by whoever loads them.
void apply(const PriorKnowledge& told, Options& options);

}  // namespace omniflight::diagnosis
