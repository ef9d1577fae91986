#include "omniflight_campaign/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace omniflight::campaign {
namespace {

constexpr double kZ = 1.959963984540054;  // two-sided 95 % of the standard normal
constexpr double kTail = 0.025;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Two-sided 95 % of Student's t at 1 to 30 degrees of freedom (tables, e.g. NIST handbook 1.3.6.7.2).
constexpr double kStudent[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                               2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                               2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};

double log_choose(double n, double k) {
  return std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1);
}

}  // namespace

Estimate share(std::size_t successes, std::size_t trials) {
  if (trials == 0) return {kNone, kNone, kNone};
  const double n = static_cast<double>(trials), p = static_cast<double>(successes) / n, z2 = kZ * kZ;
  const double centre = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  // exactly so where none, or all, succeed: the difference leaves what rounding does
  return {p, successes == 0 ? 0.0 : centre - half, successes == trials ? 1.0 : centre + half};
}

Estimate mean(std::span<const double> values) {
  const std::size_t n = values.size();
  if (n == 0) return {kNone, kNone, kNone};
  const double m = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(n);
  if (n < 2) return {m, kNone, kNone};
  double sum = 0;
  for (const double v : values) sum += (v - m) * (v - m);
  const double t = n - 2 < std::size(kStudent) ? kStudent[n - 2] : kZ;
  const double half = t * std::sqrt(sum / static_cast<double>(n - 1) / static_cast<double>(n));
  return {m, m - half, m + half};
}

Estimate quantile(std::vector<double> values, double p) {
  const std::size_t n = values.size();
  if (n == 0) return {kNone, kNone, kNone};
  std::sort(values.begin(), values.end());
  const auto at = static_cast<std::size_t>(std::ceil(p * static_cast<double>(n)));
  Estimate out{values[std::clamp<std::size_t>(at, 1, n) - 1], -HUGE_VAL, HUGE_VAL};
  // B ~ binomial(n, p) values lie below the quantile: X(l) is below it when B >= l, X(u) above when B < u
  double below = 0;  // P(B <= k - 1)
  for (std::size_t k = 0; k < n; ++k) {
    const double kk = static_cast<double>(k), nn = static_cast<double>(n);
    if (k > 0 && below <= kTail) out.low = values[k - 1];
    below += std::exp(log_choose(nn, kk) + kk * std::log(p) + (nn - kk) * std::log1p(-p));
    if (1 - below <= kTail) {  // P(B <= k) >= 0.975: X(k + 1)
      out.high = values[k];
      break;
    }
  }
  return out;
}

std::vector<double> ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> out(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t j = i;
    while (j < order.size() && values[order[j]] == values[order[i]]) ++j;
    for (std::size_t k = i; k < j; ++k) out[order[k]] = 0.5 * static_cast<double>(i + j + 1);
    i = j;
  }
  return out;
}

}  // namespace omniflight::campaign
