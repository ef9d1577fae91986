#include "score_stats.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::proof {

Interval wilson(int k, int n) {
  if (n <= 0) return {};
  constexpr double z = 1.959963984540054;
  const double p = static_cast<double>(k) / n, zz = z * z / n;
  const double middle = (p + zz / 2) / (1 + zz);
  const double half = z / (1 + zz) * std::sqrt(p * (1 - p) / n + zz / (4.0 * n));
  return {k == 0 ? 0.0 : middle - half, k == n ? 1.0 : middle + half};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto half = static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), values.begin() + half, values.end());
  const double upper = values[static_cast<std::size_t>(half)];
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values.begin(), values.begin() + half));
}

}  // namespace omniflight::proof
