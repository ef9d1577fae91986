// Makes one case of a family: turns what is hidden to its size, flies it, and writes what may be seen and
// what may not.
#pragma once

#include <string>

#include "family_draw.hpp"

namespace omniflight::proof {

struct MadeFamilyCase {
  std::string recording;  ///< canonical CSV, gzip
  std::string vehicle;    ///< vehicle YAML
  std::string told;       ///< told.yaml
  FamilyCase truth;
};

/// What the vehicle loader of this workspace knows of the vehicle file; the rest is left out of it.
struct LoaderKnows {
  bool servo = false;  ///< tilt.time_constant_s, tilt.backlash_deg
};
LoaderKnows what_the_loader_knows();

/// Errors: a flight that is lost at every size of what is hidden, naming the case.
Result<MadeFamilyCase> make_family_case(const FamilyPlan& plan, const std::string& salt, Box box,
                                        const LoaderKnows& loader);

}  // namespace omniflight::proof
