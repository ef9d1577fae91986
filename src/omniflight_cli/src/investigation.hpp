// Fly, diagnose, fly what would tell the explanations apart, until one answer is left.
#pragma once

#include "campaign.hpp"

namespace omniflight::cli {

/// What all flights up to this one say together.
struct Round {
  std::string flight;   ///< folder of the newest
  std::string verdict;  ///< of diagnosis.json
  std::vector<std::vector<std::string>>
      findings;                 ///< effects that cannot be told apart, the first the likeliest
  double separation_sigma = 0;  ///< predicted of the proposed flight; 0: none was proposed

  bool open() const;  ///< several explanations are left
};

struct Investigation {
  std::vector<Round> rounds;  ///< one a diagnosis
  std::string ended;          ///< why no further flight: "one answer is left", ...

  /// Effects of the last diagnosis, "hung_cable and payload_mass"; empty while several explanations are left.
  std::string cause() const;
};
nlohmann::json to_json(const Investigation& investigation);
/// "payload_mass or thrust_scale after 1 flight; payload_mass after 2 flights: one answer is left"
std::string in_words(const Investigation& investigation);

/// Diagnoses a flown case, in `diagnosis1`, ... below its folder, and flies what is proposed, in `next1`,
/// ..., in the same world with other noise: `most` flights beyond the first at most. keep: a flight of an
/// earlier run is taken when it was the same.
Result<Investigation> investigate(const Case& flown, int most, bool keep);

/// flight.json of an earlier run, when it tells of exactly this flight.
std::optional<nlohmann::json> flown_before(const FlightOptions& options);

}  // namespace omniflight::cli
