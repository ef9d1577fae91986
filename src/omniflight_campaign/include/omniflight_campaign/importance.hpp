// Which of the varied parameters the result depends on, from the flights that were flown anyway.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "omniflight_campaign/statistics.hpp"

namespace omniflight::campaign {

/// Of one varied parameter.
struct Importance {
  /// First-order index: share of the result's variance that would go if this parameter alone were known,
  /// Var(E[Y | X]) / Var(Y). Chance gives about 0; small values may come out negative.
  Estimate first_order;
  /// Standardised rank regression coefficient: direction and strength of a monotonic relation, -1 to 1.
  double rank_coefficient = 0;
};

struct ImportanceResult {
  std::vector<Importance> of;  ///< in the order of the parameters
  /// Share of the variance of the ranks that the rank regression explains: near 1, the coefficients say
  /// everything; far below, the relation is not monotonic or parameters interact.
  double explained_by_ranks = 0;
};

/// Importance of each parameter for a result, both as ranks: one lost flight among good ones does not hide
/// the rest.
///
/// First-order index by equal-frequency bins of the parameter (Plischke, Borgonovo and Smith 2013, European
/// Journal of Operational Research 226, 536-550), less what bins explain by chance (epsilon squared, Kelley
/// 1935), with a percentile bootstrap interval. Rank coefficients: Iman and Conover 1979, Technometrics 21,
/// 499-509. Limits: parameters must have been drawn independently; what parameters do only together
/// (interaction) is in no first-order index and shows as a sum well below 1; below some 100 flights the
/// intervals are wide.
///
/// parameters: one vector a parameter, each as long as result. Fewer than 20 flights, or a result that is the
/// same in all of them, give nothing (an empty list).
ImportanceResult importance(std::span<const std::vector<double>> parameters, std::span<const double> result,
                            std::uint64_t seed = 1);

}  // namespace omniflight::campaign
