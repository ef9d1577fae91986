// Prediction errors and their gradient, as a cost of Ceres.
#pragma once

#include <ceres/cost_function.h>

#include "omniflight_identification/fit.hpp"

namespace omniflight::identification {

/// e = (D / C)(A y - B / F u) of every counted sample of every experiment, divided by `scale`, and its
/// derivatives (Ljung 1999, section 10.3). Not evaluated where C or F is unstable: the search turns back
/// there.
class PredictionError : public ceres::CostFunction {
 public:
  PredictionError(PolynomialModel model, const Dataset& data, Eigen::Index skip, double scale);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;
  /// Residuals [unit of y / scale] and the gradient, a row a sample.
  bool evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd& e, Eigen::MatrixXd* gradient) const;

 private:
  PolynomialModel model_;
  const Dataset& data_;
  Eigen::Index skip_, count_ = 0;
  double scale_;
};

}  // namespace omniflight::identification
