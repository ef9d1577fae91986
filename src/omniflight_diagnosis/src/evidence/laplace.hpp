// Evidence of one set of hypotheses: Laplace's approximation at the Gauss-Newton optimum; exact for what is
// linear (effects' amplitudes, initial states, calibration).
#pragma once

#include <memory>

#include "../numerics/statistics.hpp"
#include "../search/hypothesis.hpp"
#include "set_coordinates.hpp"

namespace omniflight::diagnosis {

/// What a member is expected to do: its wrench at predicted states times its first stage. N and Nm, all rows.
Eigen::VectorXd expected_wrench(const RegressionProblem& problem, const Hypothesis& hypothesis,
                                const SetMember& member);

struct SetFit {
  std::vector<SetMember> members;
  Eigen::VectorXd calibration;  ///< coefficients of the problem's calibration columns
  double log_evidence = 0;      ///< ln p(z | set) up to a constant that all sets share
  Eigen::VectorXd rest;         ///< whitened residual at the optimum
  /// Whitened derivatives by the standardised coordinates: first those of calibration, which all sets of an
  /// evidence share, then those of the members and of errors of their laws.
  std::shared_ptr<const Eigen::MatrixXd> calibration_columns;
  Eigen::MatrixXd columns;
  Eigen::VectorXd moment;               ///< inner products of all of them with `rest`
  Eigen::VectorXd coordinates;          ///< at the optimum
  Eigen::MatrixXd precision;            ///< posterior precision of the coordinates
  std::vector<Eigen::Index> first;      ///< index of the first coordinate of each member
  std::vector<double> theta_deviation;  ///< posterior standard deviations of all members' theta, in order
};

/// ln density, up to a constant, of Calibration::totals being zero where columns have these deviations.
double log_density_of_totals(const Calibration& calibration, const Eigen::VectorXd& deviations);

/// Cosine amplitudes of what all sets of a problem share, its residual and its calibration: no noise changes
/// them.
struct FittedAmplitudes {
  explicit FittedAmplitudes(const RegressionProblem& problem);
  Eigen::MatrixXd residual;  ///< one column
  Eigen::MatrixXd calibration;
};

/// The residual is one observation, what the laboratory told of totals of the calibration another, in
/// NoiseModel::kBeside rows of their own: Calibration::totals of these coordinates are zero within one.
/// Evidences are those of the residual given the other.
class Evidence {
 public:
  /// `tolerances`: over those of the problem, one number a calibration column, see Calibration::deviations.
  Evidence(const RegressionProblem& problem, const FittedAmplitudes& fitted, const NoiseModel& noise,
           const std::vector<Hypothesis>& hypotheses, double law_error, const Eigen::VectorXd& tolerances);
  /// The same where no other evidence of the problem is asked for.
  Evidence(const RegressionProblem& problem, const NoiseModel& noise,
           const std::vector<Hypothesis>& hypotheses, double law_error, const Eigen::VectorXd& tolerances);

  /// The same noise beside other tolerances.
  Evidence with(const Eigen::VectorXd& tolerances) const;

  /// Maximises the posterior density from these values and integrates around it.
  SetFit fit(std::vector<SetMember> members) const;

  /// A hypothesis at a point of its grid (-1: a pattern) with these standardised amplitudes and, behind them,
  /// initial states.
  SetMember member_at(int hypothesis, int point, const Eigen::VectorXd& amplitudes) const;

  const Eigen::VectorXd& whitened_residual() const { return z_; }
  const Eigen::MatrixXd& calibration_columns() const { return *b_; }
  const Eigen::VectorXd& tolerances() const { return tolerances_; }
  const RegressionProblem& problem() const { return problem_; }
  const NoiseModel& noise() const { return noise_; }
  const std::vector<Hypothesis>& hypotheses() const { return hypotheses_; }

 private:
  class Descent;
  /// Gives members these coordinates, and says what they leave and the derivatives.
  void evaluate(const SetCoordinates& coordinates, const Eigen::VectorXd& u, std::vector<SetMember>& members,
                Eigen::VectorXd& rest, Eigen::MatrixXd* columns) const;
  double first_stage_of(const SetMember& member) const;

  const RegressionProblem& problem_;
  const NoiseModel& noise_;
  const std::vector<Hypothesis>& hypotheses_;
  double law_error_;
  Eigen::VectorXd tolerances_;
  Eigen::VectorXd deviations_;                ///< of the calibration over the problem's
  Eigen::VectorXd z_;                         ///< whitened residual
  std::shared_ptr<const Eigen::MatrixXd> b_;  ///< whitened calibration columns
  Eigen::MatrixXd bb_;                        ///< their inner products
  double log_totals_ = 0;                     ///< ln density of what was told of totals
};

}  // namespace omniflight::diagnosis
