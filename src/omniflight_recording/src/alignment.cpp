#include "omniflight_recording/alignment.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::recording {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

struct Fit {
  double correlation = 0, gain = 0;
  ArrayXXd residual;
};

/// Compares rows [from, from + n) of a with rows shifted by `lag` rows of b (fractional: linear).
ArrayXXd shifted(const ArrayXXd& b, Index from, Index n, double lag) {
  const auto whole = static_cast<Index>(std::floor(lag));
  const double part = lag - static_cast<double>(whole);
  return (1 - part) * b.middleRows(from + whole, n) + part * b.middleRows(from + whole + 1, n);
}

Fit compare(const ArrayXXd& a, const ArrayXXd& b, Index from, Index n, double lag) {
  ArrayXXd x = a.middleRows(from, n), y = shifted(b, from, n, lag);
  x.rowwise() -= x.colwise().mean().eval();
  y.rowwise() -= y.colwise().mean().eval();
  const double xx = x.square().sum(), yy = y.square().sum(), xy = (x * y).sum();
  Fit fit;
  if (xx > 0 && yy > 0) {
    fit.correlation = xy / std::sqrt(xx * yy);
    fit.gain = xy / xx;
    fit.residual = y - fit.gain * x;
  }
  return fit;
}

/// The largest value that is not on the two slopes of the peak at `at`.
double beyond_the_peak(const std::vector<double>& r, std::ptrdiff_t at) {
  constexpr double kFoot = 0.7;  // of the peak: noise on a slope is no other peak
  auto left = r.begin() + at, right = left;
  const double foot = kFoot * *left;
  while (left != r.begin() && (*left > foot || *(left - 1) < *left)) --left;
  while (right + 1 != r.end() && (*right > foot || *(right + 1) < *right)) ++right;
  double most = 0;
  for (auto v = r.begin(); v != left; ++v) most = std::max(most, *v);
  for (auto v = right + 1; v != r.end(); ++v) most = std::max(most, *v);
  return most;
}

}  // namespace

Result<LagEstimate> estimate_lag(const Signal& a, const Signal& b, const LagOptions& options) {
  const std::string where = a.name + " and " + b.name;
  if (a.width() != b.width() || a.width() == 0)
    return bad_input("the signals have different widths", where, "Choose signals of the same kind");
  if (a.size() < 2 || b.size() < 2) return bad_input("there are too few samples to align", where);
  const double from = std::max({options.from_s, a.t_s.front(), b.t_s.front()});
  const double to = std::min({options.to_s, a.t_s.back(), b.t_s.back()});
  const double dt = std::clamp(std::min(a.median_period_s(), b.median_period_s()), 1e-4, 0.1);
  const double count = (to - from) / dt;
  const auto max_rows = static_cast<Index>(std::ceil(std::clamp(options.max_lag_s, dt, 10.0) / dt));
  if (!(count > 50 + 2.0 * static_cast<double>(max_rows)) || count > 2e6)
    return bad_input("the signals share too short or too long a time to align", where,
                     "Choose a window of at least 50 samples plus twice the largest lag");
  std::vector<double> grid(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < grid.size(); ++i) grid[i] = from + static_cast<double>(i) * dt;
  const ArrayXXd x = resample(a, grid).array(), y = resample(b, grid).array();
  const Index start = max_rows + 1, n = static_cast<Index>(grid.size()) - 2 * (max_rows + 1) - 1;
  if (n < 50) return bad_input("the signals share too short a time to align", where);

  std::vector<double> r;
  for (Index lag = -max_rows; lag <= max_rows; ++lag)
    r.push_back(compare(x, y, start, n, static_cast<double>(lag)).correlation);
  for (double& v : r) v = options.same_sign ? std::max(0.0, v) : std::abs(v);
  const auto best = std::max_element(r.begin(), r.end());
  const auto at = best - r.begin();
  if (!(*best > 0.05))
    return bad_input("the signals do not vary together", where, "Choose a window with motion");
  if (at == 0 || at + 1 == static_cast<std::ptrdiff_t>(r.size()))
    return bad_input("the best lag lies at the edge of the search", where, "Search a larger lag");
  // Parabola through the three best points.
  const double left = r[static_cast<std::size_t>(at - 1)], mid = *best,
               right = r[static_cast<std::size_t>(at + 1)];
  const double curvature = left - 2 * mid + right;
  const double part = curvature < 0 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0.0;
  const double lag_rows = static_cast<double>(at - max_rows) + part;

  const Fit fit =
      compare(x, y, start, n, std::clamp(lag_rows, -static_cast<double>(max_rows), max_rows - 1e-9));
  // y(t + lag) = g x(t) + residual; d/dlag of the model is g x', so var(lag) = var(residual) / sum (g x')^2,
  // enlarged by the residual's correlation time (first-order autoregressive).
  const ArrayXXd slope = fit.gain * (x.middleRows(start + 1, n) - x.middleRows(start - 1, n)) / (2 * dt);
  const double energy = slope.square().sum(), noise = fit.residual.square().mean();
  const double rho = std::clamp((fit.residual.topRows(n - 1) * fit.residual.bottomRows(n - 1)).sum() /
                                    std::max(fit.residual.square().sum(), 1e-300),
                                0.0, 0.999);
  LagEstimate out;
  out.lag_s = lag_rows * dt;
  out.standard_error_s = energy > 0 ? std::sqrt(noise / energy * (1 + rho) / (1 - rho)) : 1e9;
  out.correlation = fit.correlation;
  out.gain = fit.gain;
  out.rival = beyond_the_peak(r, at);
  return out;
}

}  // namespace omniflight::recording
