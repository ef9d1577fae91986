#include "catenary.hpp"

#include <algorithm>

namespace omniflight::physics {
namespace {

constexpr double kTight = 1e-15, kLoose = 1e-3;
constexpr double kNoSag = 1e-12;  ///< of the tension: a straight line is as near as this

/// Root of an increasing function in [low, high] by safeguarded secants; f(low) <= 0 <= f(high).
template <class Function>
double increasing_root(const Function& f, double low, double high, double tolerance) {
  double f_low = f(low), f_high = f(high);
  for (int k = 0; k < 200 && high - low > tolerance * std::max(1.0, high); ++k) {
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

/// Nested search: always finds the answer, to `tolerance` relative to max(1 m, a).
CatenaryEnds search(double distance, double height, double length, double stretch, double tolerance) {
  // For given a the height rises with b, and along that line the distance rises with a.
  const auto rise = [&](double a, double b) {
    const double u = b > length ? b - length : 0.0;
    return std::sqrt(a * a + b * b) - std::sqrt(a * a + u * u) + 0.5 * stretch * (b * b - u * u);
  };
  // While some of it lies on the floor, s = sqrt(a^2 + b^2) - a solves a quadratic.
  const auto lying = [&](double a) {
    const double p = 1 + stretch * a, s = 2 * height / (p + std::sqrt(p * p + 2 * stretch * height));
    return std::sqrt(s * (s + 2 * a));
  };
  const auto vertical = [&](double a) {
    if (const double b = lying(a); b <= length) return b;
    double high = height + length;
    while (rise(a, high) < height) high *= 2;
    return increasing_root([&](double b) { return rise(a, b) - height; }, length, high, tolerance);
  };
  const auto miss = [&](double a) { return catenary_span(a, vertical(a), length, stretch).first - distance; };
  constexpr double kHangs = 1e-9;
  if (miss(kHangs) >= 0) {
    if (const double b = lying(0); b <= length) return {0.0, b};
    return {0.0, (height - length + 0.5 * stretch * length * length) / (stretch * length)};
  }
  double high = length;
  while (miss(high) < 0) high *= 4;
  const double a = increasing_root(miss, kHangs, high, tolerance);
  return {a, vertical(a)};
}

/// Newton in both unknowns from `ends`; true when it settled at a root.
bool polish(double distance, double height, double length, double stretch, CatenaryEnds& ends) {
  using Two = ceres::Jet<double, 2>;
  double last = 1e300;
  for (int k = 0; k < 12; ++k) {
    const auto [x, z] = catenary_span(Two(ends.a, 0), Two(ends.b, 1), Two(length), Two(stretch));
    const double det = x.v[0] * z.v[1] - x.v[1] * z.v[0], dx = x.a - distance, dz = z.a - height;
    const double step_a = -(z.v[1] * dx - x.v[1] * dz) / det, step_b = -(x.v[0] * dz - z.v[0] * dx) / det;
    const CatenaryEnds next{ends.a + step_a, ends.b + step_b};
    if (!(next.a > 0) || !(next.b > 0) || !std::isfinite(next.a + next.b)) return false;
    ends = next;
    const double step = std::abs(step_a) + std::abs(step_b), size = std::max(1.0, ends.a + ends.b);
    // a cable that is just taut takes its tension from the last digits of the span:
    // steps stop shrinking there
    if (step <= 1e-13 * size || (step <= 1e-9 * size && step > 0.5 * last)) return true;
    last = step;
  }
  return false;
}

}  // namespace

CatenaryEnds solve_catenary_ends(double distance, double height, double length, double stretch) {
  // A tight cable is nearly the straight elastic line between its ends, from where Newton is there at once.
  const double chord = std::hypot(distance, height);
  if (chord > length && distance > 0) {
    const double strain = chord / length - 1, pull = strain / stretch;
    CatenaryEnds straight{pull * distance / chord, pull * height / chord + 0.5 * length};
    // beyond this its sag changes no digit that the span could still tell
    if (length * length < kNoSag * strain * pull * pull) return straight;
    if (polish(distance, height, length, stretch, straight)) return straight;
  }
  // A slack one begins with the guess of Jonkman 2007 (eq. 2.38); the search is for what Newton cannot reach.
  if (chord <= length && distance > 1e-3 * length) {
    const double ratio = (length * length - height * height) / (distance * distance) - 1;
    const double lambda = ratio > 0.01 ? std::sqrt(3 * ratio) : 0.2;
    CatenaryEnds slack{distance / (2 * lambda), 0.5 * (height / std::tanh(lambda) + length)};
    if (polish(distance, height, length, stretch, slack)) return slack;
  }
  CatenaryEnds ends = search(distance, height, length, stretch, kLoose);
  if (ends.a > 0 && polish(distance, height, length, stretch, ends)) return ends;
  ends = search(distance, height, length, stretch, kTight);
  if (ends.a > 0) {
    CatenaryEnds better = ends;
    if (polish(distance, height, length, stretch, better)) ends = better;
  }
  return ends;
}

}  // namespace omniflight::physics
