// Which structure and orders: judged on data that no fit has seen.
#pragma once

#include "omniflight_identification/fit.hpp"

namespace omniflight::identification {

struct DelayEstimate {
  int samples = 1;
  std::vector<double>
      loss;  ///< mean squared simulation error [unit of y]^2 at delays 1, 2, ..., to 8 past the best
};
/// Delay of input 0 [samples]: the one whose first-order Output-Error model simulates the data best. The
/// other inputs have a delay of 1. Errors as fit().
Result<DelayEstimate> estimate_delay(const Dataset& data, int most, const FitOptions& options = {});

struct SelectionOptions {
  int max_order = 3;
  int delay_spread = 1;  ///< delays this far from the estimate are tried
  FitOptions fit;
  /// A larger model must beat a smaller one by this much [percent of fit] to be chosen: what that gains on
  /// other flights of the same motor changes by more from flight to flight.
  double worth_percent = 0.3;
};

struct Candidate {
  FittedModel fitted;
  int order = 1, zeros = 0;         ///< of the plant
  double validation_percent = 0.0;  ///< fit_percent on the validation data
  double estimation_percent = 0.0;
};

/// Fits a structure in all orders up to max_order, then the best of them with delays about `delay`, and
/// returns the one that fits the validation data best, or a smaller one that is not worse by worth_percent.
/// Candidates that do not converge, or are unstable, are passed over; when all are, the last error is
/// returned.
Result<Candidate> select(Structure structure, const Dataset& estimation, const Dataset& validation, int delay,
                         const SelectionOptions& options = {});

}  // namespace omniflight::identification
