// Bayes factors of numbers and of counts, without physics.
#pragma once

#include <cmath>
#include <cstddef>

namespace omniflight::diagnosis {

/// ln Bayes factor of a number with this estimate and standard error: normal likelihood, prior N(0,
/// deviation^2) against nothing.
inline double log_factor_of_size(double estimate, double standard_error, double deviation) {
  const double s2 = standard_error * standard_error, d2 = deviation * deviation;
  return 0.5 * estimate * estimate / s2 * d2 / (s2 + d2) - 0.5 * std::log1p(d2 / s2);
}

/// The same of samples that repeat the one before bit for bit while the quantity changes: a sensor that works
/// does so by chance in less than one of two.
inline double log_factor_of_repeats(std::ptrdiff_t samples) {
  return static_cast<double>(samples) * std::log(2.0);
}

}  // namespace omniflight::diagnosis
