// Standardised coordinates of a set of hypotheses: each is a priori normal with mean zero and variance one,
// some between bounds.
#pragma once

#include <vector>

#include "../search/hypothesis.hpp"
#include "set_member.hpp"

namespace omniflight::diagnosis {

/// Calibration first, then of each member its parameters and initial states, or the weights of a pattern.
/// More may be added behind them.
class SetCoordinates {
 public:
  struct Parameter {
    physics::ParameterPrior prior;
    double low = 0, high = 0;  ///< bounds of the coordinate
  };

  /// Gives members that have none their initial states (zero).
  SetCoordinates(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
                 Eigen::Index calibration, std::vector<SetMember>& members);

  Eigen::Index calibration() const { return calibration_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(bounds_.size()); }
  /// Index of the first coordinate of each member.
  const std::vector<Eigen::Index>& first() const { return first_; }
  const std::vector<Parameter>& parameters(std::size_t member) const { return parameters_[member]; }
  /// Unbounded ones behind the others.
  void append(Eigen::Index count);

  /// Of members at their values; those of calibration are zero.
  Eigen::VectorXd of(const std::vector<SetMember>& members) const;
  /// Gives a member the values of these coordinates.
  void give(const Eigen::VectorXd& u, std::size_t index, SetMember& member) const;

  Eigen::VectorXd within_bounds(const Eigen::VectorXd& u) const;
  /// 1 and -1 at the lower and the upper bound of a coordinate, 0 between.
  int inward(Eigen::Index k, double u) const {
    const Bounds& b = bounds_[static_cast<std::size_t>(k)];
    return u <= b.low ? 1 : u >= b.high ? -1 : 0;
  }
  /// Those that are at no bound.
  std::vector<Eigen::Index> free(const Eigen::VectorXd& u) const;

  /// ln of the posterior's integral over its density at u, by its quadratic there (precision and gradient):
  /// over all coordinates between bounds, then over one side of those at a bound, each by itself. Less ln of
  /// the prior's mass within bounds: what would have to lie beyond them to explain the residual is no
  /// evidence.
  double log_integral(const Eigen::VectorXd& u, const Eigen::MatrixXd& precision,
                      const Eigen::VectorXd& gradient) const;

 private:
  struct Bounds {
    double low = -1e9, high = 1e9;
  };
  const std::vector<Hypothesis>& hypotheses_;
  Eigen::Index calibration_ = 0;
  std::vector<Eigen::Index> first_;
  std::vector<std::vector<Parameter>> parameters_;  ///< a member
  std::vector<Bounds> bounds_;
};

}  // namespace omniflight::diagnosis
