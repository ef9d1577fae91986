#include "catenary.hpp"

#include <algorithm>

namespace omniflight::physics {
namespace {

/// Root of an increasing function in [low, high] by safeguarded secants; f(low) <= 0 <= f(high).
template <class Function>
double increasing_root(const Function& f, double low, double high) {
  double f_low = f(low), f_high = f(high);
  for (int k = 0; k < 200 && high - low > 1e-15 * std::max(1.0, high); ++k) {
    double at = 0.5 * (low + high);
    if (k % 3 != 2 && f_high > f_low) {
      const double secant = low - f_low * (high - low) / (f_high - f_low);
      if (secant > low && secant < high) at = secant;
    }
    const double value = f(at);
    if (value == 0) return at;
    (value < 0 ? low : high) = at;
    (value < 0 ? f_low : f_high) = value;
  }
  return 0.5 * (low + high);
}

}  // namespace

CatenaryEnds solve_catenary_ends(double distance, double height, double length, double stretch) {
  // For given a the height rises with b, and along that line the distance rises with a.
  const auto vertical = [&](double a) {
    double high = height + length;
    while (catenary_span(a, high, length, stretch).second < height) high *= 2;
    return increasing_root([&](double b) { return catenary_span(a, b, length, stretch).second - height; },
                           0.0, high);
  };
  const auto miss = [&](double a) { return catenary_span(a, vertical(a), length, stretch).first - distance; };
  constexpr double kHangs = 1e-9;
  if (miss(kHangs) >= 0) return {0.0, vertical(kHangs)};
  double high = length;
  while (miss(high) < 0) high *= 4;
  const double a = increasing_root(miss, kHangs, high);
  // two steps of Newton in both unknowns take the rounding of the nested search away
  CatenaryEnds ends{a, vertical(a)};
  using Two = ceres::Jet<double, 2>;
  for (int k = 0; k < 2; ++k) {
    const auto [x, z] = catenary_span(Two(ends.a, 0), Two(ends.b, 1), Two(length), Two(stretch));
    const double det = x.v[0] * z.v[1] - x.v[1] * z.v[0], dx = x.a - distance, dz = z.a - height;
    const CatenaryEnds next{ends.a - (z.v[1] * dx - x.v[1] * dz) / det,
                            ends.b - (x.v[0] * dz - z.v[0] * dx) / det};
    if (!(next.a > 0) || !std::isfinite(next.b)) break;
    ends = next;
  }
  return ends;
}

}  // namespace omniflight::physics
