// What a sample of flights says about all flights that could have been drawn: estimates with 95 % intervals.
#pragma once

#include <span>
#include <vector>

namespace omniflight::campaign {

/// An estimate and its two-sided 95 % confidence interval; not a number where there is none.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

/// Share of successes by Wilson's score interval (Wilson 1927), which holds also at 0 and 1.
Estimate share(std::size_t successes, std::size_t trials);

/// Mean by Student's t (normal beyond 30 values; the sample mean is nearly normal then). Two values at least.
Estimate mean(std::span<const double> values);

/// Quantile p in (0, 1): the order statistic, and the distribution-free interval between two order statistics
/// by the binomial law of how many values lie below (David and Nagaraja, Order Statistics, 2003, 7.1). An end
/// that no order statistic reaches is infinite: the sample is too small for that quantile.
Estimate quantile(std::vector<double> values, double p);

/// Ranks 1..n of the values, ties with their mean rank.
std::vector<double> ranks(std::span<const double> values);

}  // namespace omniflight::campaign
