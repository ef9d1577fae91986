// Elastic catenary over a frictionless floor: from the span to the forces at its upper end.
#pragma once

#include <cmath>
#include <utility>

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

/// Horizontal and vertical tension at the upper end, each over the weight per length: H = w a, V = w b [m].
struct CatenaryEnds {
  double a = 0, b = 0;
};

/// Span of a cable with upper-end tensions a, b [m]: {horizontal, vertical} distance [m] of its ends. length
/// [m] unstretched; stretch e = weight per length over EA [1/m].
template <class T>
std::pair<T, T> catenary_span(const T& a, const T& b, const T& length, const T& stretch) {
  using std::log;
  using std::sqrt;
  const T u = b > length ? T(b - length) : T(0);
  const T top = sqrt(a * a + b * b), bottom = sqrt(a * a + u * u);
  // asinh(b/a) - asinh(u/a), without the division by a small a
  const T bend = a * log((b + top) / (u + bottom));
  const T lying = b > length ? T(0) : T(length - b);
  // differences of squares as products: those of large numbers would lose the digits that Newton needs
  const T squares = (b > length ? length : b) * (b + u);
  return {lying + bend + stretch * a * length, squares / (top + bottom) + T(0.5) * stretch * squares};
}

/// The inverse: tensions at which the span is {distance >= 0, height > 0} [m]. Always has an answer; a cable
/// that hangs straight down has a = 0.
CatenaryEnds solve_catenary_ends(double distance, double height, double length, double stretch);

/// The same with exact derivatives for T = ceres::Jet (implicit function theorem).
template <class T>
std::pair<T, T> solve_catenary(const T& distance, double height, const T& length, const T& stretch) {
  if constexpr (std::is_same_v<T, double>) {
    const CatenaryEnds ends = solve_catenary_ends(distance, height, length, stretch);
    return {ends.a, ends.b};
  } else {
    const CatenaryEnds ends = solve_catenary_ends(distance.a, height, length.a, stretch.a);
    using Two = ceres::Jet<double, 2>;
    const auto [x, z] =
        catenary_span(Two(std::max(ends.a, 1e-12), 0), Two(ends.b, 1), Two(length.a), Two(stretch.a));
    const auto [span, rise] = catenary_span(T(std::max(ends.a, 1e-12)), T(ends.b), length, stretch);
    if (ends.a <= 0) return {T(0), T(ends.b) - (rise - T(rise.a)) / T(z.v[1])};
    const T miss_x = (span - T(span.a)) - (distance - T(distance.a)), miss_z = rise - T(rise.a);
    const double det = x.v[0] * z.v[1] - x.v[1] * z.v[0];
    return {T(ends.a) - (T(z.v[1]) * miss_x - T(x.v[1]) * miss_z) / T(det),
            T(ends.b) - (T(x.v[0]) * miss_z - T(z.v[0]) * miss_x) / T(det)};
  }
}

}  // namespace omniflight::physics
