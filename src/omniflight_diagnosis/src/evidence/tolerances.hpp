// How well the laboratory measured its vehicle, as the flight itself shows it.
#pragma once

#include "laplace.hpp"

namespace omniflight::diagnosis {

/// The factors on the tolerances, one for each kind, under which this fitted set is likeliest (empirical
/// Bayes, automatic relevance determination of MacKay 1994 by groups): where the axes of most rotors turn out
/// to be right, they were measured better than is assumed of a vehicle of which nothing is told, and the one
/// that is not right is no matter of measuring. One number a calibration column. `current`: the factors of
/// the fit.
Eigen::VectorXd likeliest_tolerances(const Calibration& calibration, const SetFit& fit,
                                     const Eigen::VectorXd& current);

/// ln of the prior of these factors, over its greatest value. Laboratories differ in care, and kinds of
/// numbers within one of them: what it tells of some says how well it knows the others. Flat where nothing is
/// told.
double log_prior_of_tolerances(const Calibration& calibration, const Eigen::VectorXd& factors);

/// The least of these factors for every kind.
Eigen::VectorXd tightest_tolerances(const Calibration& calibration);

}  // namespace omniflight::diagnosis
