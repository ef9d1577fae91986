#include "outliers.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace omniflight::diagnosis {
namespace {

/// Distance over its local mean above which a sample is an outlier. Chosen: the mean distance of white noise
/// is about 0.6 standard deviations, so that this is about 6 of them.
constexpr double kFarOverNear = 10;
/// Samples of a block of the local mean: the motion changes along a flight
constexpr Eigen::Index kLocal = 50;

/// Smallest distance of a sample from its interpolation by both neighbours and from its linear extrapolations
/// from the two samples before and the two after. It is small on slopes, on both sides of a step, and next to
/// an outlier.
double distance(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Index i) {
  const double expected[] = {0.5 * (x[i - 1] + x[i + 1]), 2 * x[i - 1] - x[i - 2], 2 * x[i + 1] - x[i + 2]};
  double nearest = std::abs(x[i] - expected[0]);
  for (const double e : expected) nearest = std::min(nearest, std::abs(x[i] - e));
  return std::isfinite(nearest) ? nearest : 0.0;
}

/// Mean of the lowest 90 %.
double trimmed_mean(std::vector<double> x) {
  const std::size_t kept = x.size() * 9 / 10;
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(kept), x.end());
  double sum = 0;
  for (std::size_t k = 0; k < kept; ++k) sum += x[k];
  return sum / static_cast<double>(std::max<std::size_t>(1, kept));
}

}  // namespace

recording::Signal without_outliers(const recording::Signal& signal) {
  recording::Signal out = signal;
  const Eigen::Index n = signal.size(), blocks = n / kLocal;
  if (blocks < 4) return out;
  std::vector<double> far(static_cast<std::size_t>(n)), scale(static_cast<std::size_t>(blocks));
  for (Eigen::Index c = 0; c < signal.values.cols(); ++c) {
    const Eigen::VectorXd x = signal.values.col(c);
    for (Eigen::Index i = 2; i + 2 < n; ++i) far[static_cast<std::size_t>(i)] = distance(x, i);
    for (Eigen::Index b = 0; b < blocks; ++b)
      scale[static_cast<std::size_t>(b)] =
          trimmed_mean({far.begin() + b * kLocal, far.begin() + (b + 1) * kLocal});
    for (Eigen::Index i = 2; i + 2 < n; ++i) {
      const Eigen::Index b = std::min(i / kLocal, blocks - 1);
      double near = 0;
      for (Eigen::Index k = std::max<Eigen::Index>(0, b - 1); k <= std::min(b + 1, blocks - 1); ++k)
        near = std::max(near, scale[static_cast<std::size_t>(k)]);
      if (near > 0 && far[static_cast<std::size_t>(i)] > kFarOverNear * near)
        out.values(i, c) = 0.5 * (x[i - 1] + x[i + 1]);
    }
  }
  return out;
}

}  // namespace omniflight::diagnosis
