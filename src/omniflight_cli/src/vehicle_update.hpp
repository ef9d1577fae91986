// Identified figures written into a vehicle file, which keeps its comments and its order.
#pragma once

#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::cli {

/// A number of every rotor, in the order of the file.
struct RotorField {
  std::string key;             ///< as in the file, for instance "time_constant"
  std::vector<double> values;  ///< SI, one a rotor; NaN leaves the rotor's as it is
  std::string provenance;      ///< one line, where the values are from
};

/// Puts the fields into the file of a vehicle (a name or a path) and their sources under its `provenance`.
/// The new file is loaded and checked before it replaces the old one. Returns its path. Errors: a file that
/// does not write the key once for each rotor, or provenance that is no block: then nothing is written and
/// the error has the numbers.
Result<std::string> update_vehicle(const std::string& vehicle, const std::vector<RotorField>& fields);

}  // namespace omniflight::cli
