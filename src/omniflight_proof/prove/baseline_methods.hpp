// Textbook methods that name terms from a residual: what the proof compares with.
#pragma once

#include <string>
#include <vector>

#include "baseline_data.hpp"

namespace omniflight::proof {

struct NamedTerm {
  std::string id, stage;
  double strength = 0;  ///< t value or gain, for the order
  std::vector<std::string> parameters;
  std::vector<double> values, errors;  ///< one standard error each, as the method believes
};
struct BaselineAnswer {
  bool mismatch = false;
  std::vector<NamedTerm> terms;  ///< strongest first; empty for a black box
};

/// All terms at once, ordinary least squares; a term is named when one of its columns passes the t-test at 5
/// %, Bonferroni over all columns (data-driven-dynamics and many others).
BaselineAnswer least_squares(const BaselineData& data);
/// Sequentially thresholded least squares (SINDy): columns of unit size, those below `threshold` times the
/// residual are dropped, until nothing changes.
BaselineAnswer thresholded(const BaselineData& data, double threshold = 0.1);
/// Forward stepwise by BIC over terms (Klein and Morelli); whiten: autoregressive residuals of order 8,
/// fitted anew at every step.
BaselineAnswer stepwise(const BaselineData& data, bool whiten);
/// The terms that are there and no others, generalised least squares with autoregressive noise of order 8:
/// what a fit can know at best. ids: of the terms; those that the library has not are passed over.
BaselineAnswer oracle(const BaselineData& data, const std::vector<std::string>& ids);
/// Piecewise-linear splines in every variable alone, ridge; a mismatch when it explains more than 2 % of
/// held-out blocks in some channel. Names nothing.
BaselineAnswer black_box(const BaselineData& data);

}  // namespace omniflight::proof
