// First stage of two-stage least squares: what of a measured regressor its prediction tells.
#pragma once

#include <Eigen/Dense>

namespace omniflight::diagnosis {

/// F statistic of a first stage below which an instrument is weak (Staiger and Stock 1997).
inline constexpr double kWeakInstrument = 10;

/// Whether the F statistic of a first stage is below that. It is the one that is robust to unequal
/// variances (White 1980): what a column leaves is in the channels and frequencies in which it is, and in no
/// others. `left`: what the coefficient leaves of the measured column.
bool is_weak(const Eigen::Ref<const Eigen::VectorXd>& instrument, double coefficient,
             const Eigen::Ref<const Eigen::VectorXd>& left);

/// Coefficient of the regression of a whitened measured column on the whitened predicted one. The prediction
/// is an instrument: it times this coefficient stands for the measured column, so that the coefficient of an
/// effect is x^T y / x^T m with predicted x and measured m, whatever share of m is predictable. Zero where
/// the instrument is weak.
double first_stage(const Eigen::Ref<const Eigen::VectorXd>& predicted,
                   const Eigen::Ref<const Eigen::VectorXd>& measured);

/// The same of each column.
Eigen::VectorXd first_stages(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& measured);

}  // namespace omniflight::diagnosis
