#include "torque_alignment.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

std::optional<TorqueLag> lag_behind_rotors(const RotorRegression& regression) {
  if (!regression.enough()) return std::nullopt;
  const int at = regression.best_shift();
  if (std::abs(at) == regression.reach()) return std::nullopt;
  // Under a disturbance that the controller compensates, the lag is that of the controller: the torques must
  // explain the motion, with positive sign.
  TorqueLag out;
  for (int c = 0; c < 3; ++c) out.explained = std::max(out.explained, 1 - regression.left_at_once(c, at));
  if (out.explained < kLeastByRotors) return std::nullopt;
  const double before = regression.misfit(at - 1), after = regression.misfit(at + 1);
  const double bend = before - 2 * regression.misfit(at) + after, rate_hz = regression.rate_hz();
  if (!(bend > 0)) return std::nullopt;
  out.lag_s = (at + 0.5 * (before - after) / bend) / rate_hz;
  out.se_s = 1 / (rate_hz * std::sqrt(bend * regression.independent_samples()));
  return out;
}

Eigen::MatrixXd delayed(const Eigen::MatrixXd& x, double lag_s, double rate_hz) {
  Eigen::MatrixXd out(x.rows(), x.cols());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double at =
        std::clamp(static_cast<double>(i) - lag_s * rate_hz, 0.0, static_cast<double>(x.rows() - 1));
    const auto a = static_cast<Eigen::Index>(at);
    const Eigen::Index b = std::min(a + 1, x.rows() - 1);
    out.row(i) = x.row(a) + (at - static_cast<double>(a)) * (x.row(b) - x.row(a));
  }
  return out;
}

}  // namespace omniflight::diagnosis
