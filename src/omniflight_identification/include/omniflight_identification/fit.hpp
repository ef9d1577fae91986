// Models from data: least squares for ARX, prediction-error minimisation for the rest.
#pragma once

#include <complex>
#include <functional>

#include "omniflight_identification/polynomial_model.hpp"

namespace omniflight::identification {

struct FitOptions {
  Eigen::Index transient_samples =
      50;                      ///< of each experiment that do not count: the initial state is not known
  int max_iterations = 60;     ///< of the search
  std::function<bool()> stop;  ///< true ends every search; empty: never
};

struct FittedModel {
  Structure structure = Structure::arx;
  PolynomialModel model;
  /// Of parameters(). From the innovations' variance and the prediction's gradient; where the residuals are
  /// correlated, with their correlation (Newey and West 1987), because then the former is too small.
  Eigen::MatrixXd covariance;
  bool correlated_residuals = false;
  double variance = 0.0;  ///< of the one-step prediction error, [unit of y]^2
  Eigen::Index samples = 0;
  int iterations = 0;
  bool converged = false;  ///< false: stopped, or out of iterations
};

/// Fits a structure. Data should be detrended. Errors: check(), fewer than five samples a parameter, inputs
/// that do not excite the model (rank), an unstable plant (`impossible` is not claimed: bad_input with the
/// pole), a stop before the start was found (incomplete).
Result<FittedModel> fit(Structure structure, const Orders& orders, const Dataset& data,
                        const FitOptions& options = {});

/// Poles of order n from the data alone, by regression of future outputs on past data and future inputs, and
/// a singular value decomposition (Van Overschee and De Moor 1996; Larimore's weighting): coefficients of A.
Result<Eigen::VectorXd> subspace_denominator(int order, const std::vector<int>& delay, const Dataset& data);

}  // namespace omniflight::identification
