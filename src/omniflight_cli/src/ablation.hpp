// Ablations: a diagnosis without one of its safeguards, or given something wrong that nobody tells it. What a
// proof asks to see what the safeguards are worth and what an answer bears.
#pragma once

#include <string>
#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::cli {

/// Ids, in the order of --help.
const std::vector<std::string>& ablations();
/// "id: what it does", a line each.
std::string ablations_help();
/// Makes recordings or vehicle wrong. An id that changes nothing here does nothing.
void ablate_input(const std::string& id, std::vector<recording::Recording>& recordings, vehicle::Vehicle& vehicle);
/// Takes a safeguard away, after the options are complete.
void ablate_options(const std::string& id, diagnosis::Options& options);

}  // namespace omniflight::cli
