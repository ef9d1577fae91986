// Which cases there are: kinds, flights, mechanisms and magnitudes, all drawn from the salt and shuffled, so
// that neither number nor order tells anything.
#pragma once

#include <string>
#include <vector>

#include "case_mechanism.hpp"

namespace omniflight::proof {

inline constexpr const char* kRetuned = "retuned controller";  ///< a decoy, and as often beside an effect
inline constexpr double kDecoyShare = 0.25;                    ///< of nominal cases
inline constexpr double kDecoys = 5;                           ///< kinds, equally often

struct DrawOptions {
  std::string salt;
  bool sealed = true;  ///< false: the tuning box, with other magnitudes and shapes
  int cases = 240;     ///< with effects
  int nulls = 300;     ///< without: nulls, nulls with nuisances, decoys
  std::string level;   ///< "L1" ... "L6"; empty: the mixture of the protocol
};

struct CasePlan {
  std::string id = {};
  std::string level, flight;
  std::string decoy;  ///< what is hard about the flight; of cases with effects only kRetuned
  Kind kind = Kind::null;
  double magnitude = 0;                 ///< sigma
  std::vector<std::size_t> parts = {};  ///< indices into the mechanisms
  bool nuisances = false;
};

/// Deterministic for its options. Of 240 cases about 90 are plain single effects, 30 with nuisances, 30
/// structurally different, 50 pairs and triples, 20 from no library, 20 on the thesis's flights with
/// nuisances.
std::vector<CasePlan> draw_cases(const DrawOptions& options, const std::vector<Mechanism>& mechanisms);

}  // namespace omniflight::proof
