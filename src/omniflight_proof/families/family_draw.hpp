// Which cases a families run has: where each stands among the families and what is hidden in it.
// Deterministic for the salt; every id of the catalogue comes up before any comes up again.
#pragma once

#include "hidden.hpp"

namespace omniflight::proof {

struct FamilyDrawOptions {
  std::string salt;
  Box box = Box::tuning;
  int cases = 60, nulls = 20;
  double longest = 240;                    ///< s, of a flight
  std::vector<std::string> vehicles = {};  ///< only these; empty: all of the box
  std::vector<std::string> effects = {};   ///< only these ids; empty: all
};

struct FamilyPlan {
  std::string id;
  Coordinates where;
  std::vector<std::string> unseen;
  Kind kind = Kind::null;
  std::string decoy;
  double sigma = 0;                 ///< wanted size of every effect
  std::vector<std::size_t> hidden;  ///< indices into hidden_effects()
};

inline constexpr double kSigmas[] = {0.3, 1, 3};

Result<std::vector<FamilyPlan>> draw_families(const FamilyDrawOptions& options);

/// The same effects (or none) in another place: for one that is lost or shows nothing where it was drawn.
/// attempt counts from 1.
FamilyPlan draw_again(const FamilyPlan& plan, const FamilyDrawOptions& options, int attempt);

/// Where one case stands.
Coordinates draw_coordinates(BoxRandom& random, const FamilyDrawOptions& options);
/// Coordinates that no tuning run draws, of this case.
std::vector<std::string> unseen_of(const Coordinates& where);

}  // namespace omniflight::proof
