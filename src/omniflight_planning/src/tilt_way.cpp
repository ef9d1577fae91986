#include "tilt_way.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace omniflight::planning {
namespace {

constexpr std::size_t kPlaces = 60;  // intervals of a way through tilts
constexpr int kSmoothings = 6;       // passes of a binomial filter over the steps between tilts of the range
constexpr double kReserve = 0.05;    // share of the rotors' range, for smoothing and for the motion itself

/// Tilts of least change, from the first of the range at the first place to the last at the last, through
/// those at which the attitude of each place can be hovered with a load of `allowed` (dynamic programming).
std::optional<std::vector<double>> least_change(const PoseCurve& curve, const TiltRange& range,
                                                double allowed) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const std::size_t n = range.tilts.size();
  std::vector<std::vector<std::size_t>> before(kPlaces + 1, std::vector<std::size_t>(n, 0));
  std::vector<double> cost(n, kNever);
  cost.front() = 0.0;
  for (std::size_t k = 1; k <= kPlaces; ++k) {
    const Quat q =
        curve.at(curve.length() * static_cast<double>(k) / static_cast<double>(kPlaces), 0, 0).q_WB;
    std::vector<double> next(n, kNever);
    for (std::size_t m = 0; m < n; ++m) {
      if (range.rotors[m]->load().hover_load(q) > allowed) continue;
      for (std::size_t i = 0; i < n; ++i) {
        const double change = range.tilts[m] - range.tilts[i], sum = cost[i] + change * change;
        if (sum < next[m]) next[m] = sum, before[k][m] = i;
      }
    }
    cost = std::move(next);
  }
  if (!std::isfinite(cost.back())) return {};
  std::vector<double> out(kPlaces + 1);
  for (std::size_t k = kPlaces, m = n - 1;; --k) {
    out[k] = range.tilts[m];
    if (k == 0) return out;
    m = before[k][m];
  }
}

void smooth(std::vector<double>& values) {
  for (int pass = 0; pass < kSmoothings; ++pass) {
    std::vector<double> next = values;
    for (std::size_t k = 1; k + 1 < values.size(); ++k)
      next[k] = 0.25 * values[k - 1] + 0.5 * values[k] + 0.25 * values[k + 1];
    values = std::move(next);
  }
}

}  // namespace

TiltWay::TiltWay(std::vector<double> tilts, double length)
    : step_(length / static_cast<double>(tilts.size() - 1)), value_(std::move(tilts)) {
  // second derivatives of the natural spline: tridiagonal system (Thomas), as in PoseCurve
  const std::size_t n = value_.size();
  curvature_.assign(n, 0.0);
  if (n < 3 || step_ <= 0.0) return;
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double right = 6.0 * (value_[i + 1] - 2.0 * value_[i] + value_[i - 1]) / (step_ * step_);
    const double pivot = 4.0 - upper[i - 1];
    upper[i] = 1.0 / pivot;
    curvature_[i] = (right - curvature_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i >= 1; --i) curvature_[i] -= upper[i] * curvature_[i + 1];
}

double TiltWay::at(double u) const {
  if (!(u > 0.0) || step_ <= 0.0) return value_.front();
  const double place = u / step_;
  if (place >= static_cast<double>(value_.size() - 1)) return value_.back();
  const auto k = static_cast<std::size_t>(place);
  const double b = place - static_cast<double>(k), a = 1.0 - b;
  return a * value_[k] + b * value_[k + 1] +
         step_ * step_ / 6.0 * ((a * a * a - a) * curvature_[k] + (b * b * b - b) * curvature_[k + 1]);
}

std::vector<TiltWay> tilt_ways(const PoseCurve& curve, const TiltRange& range, double headroom) {
  std::vector<TiltWay> out{TiltWay({range.tilts.front(), range.tilts.back()}, curve.length())};
  for (const double reserve : {kReserve, 0.0})
    if (auto tilts = least_change(curve, range, 1.0 - headroom - reserve)) {
      smooth(*tilts);
      out.emplace_back(std::move(*tilts), curve.length());
      break;
    }
  return out;
}

}  // namespace omniflight::planning
