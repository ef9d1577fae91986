// Where the search for a model begins. All need detrended data that check() accepts.
#pragma once

#include "omniflight_identification/fit.hpp"

namespace omniflight::identification {

/// A model of these orders with all coefficients 0.
PolynomialModel zero_model(const Orders& orders, const Dataset& data);
/// Linear regression of y on its own `a` past values and `b` values of each input. Errors: rank.
Result<PolynomialModel> least_squares_arx(const Orders& orders, const Dataset& data, Eigen::Index skip);
/// The same on signals that were filtered with 1/F of the round before, which takes its bias by output noise
/// away (Steiglitz and McBride 1965): `f` coefficients of F and those of B. The round that simulates best is
/// kept.
Result<PolynomialModel> steiglitz_mcbride(const Orders& orders, const Dataset& data, Eigen::Index skip);
/// A, B and C by two regressions: a long ARX model gives the innovations, which are then inputs (Hannan and
/// Rissanen 1982). With `denominator` A is given. With b = 0 it is a noise model of y alone.
Result<PolynomialModel> hannan_rissanen(const Orders& orders, const Dataset& data, Eigen::Index skip,
                                        const Eigen::VectorXd* denominator = nullptr);

}  // namespace omniflight::identification
