#include "torque_alignment.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

std::optional<TorqueLag> lag_behind_rotors(const RotorRegression& regression) {
  if (!regression.enough()) return std::nullopt;
  const int reach = regression.reach();
  std::vector<double> misfit;  // negative log-likelihood per sample
  for (int shift = -reach; shift <= reach; ++shift) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += 0.5 * std::log(regression.left_at_once(c, shift));
    misfit.push_back(sum);
  }
  const auto at = std::min_element(misfit.begin(), misfit.end()) - misfit.begin();
  if (at == 0 || at + 1 == static_cast<std::ptrdiff_t>(misfit.size())) return std::nullopt;
  // Under a disturbance that the controller compensates, the lag is that of the controller: the torques must
  // explain the motion, with positive sign.
  TorqueLag out;
  for (int c = 0; c < 3; ++c)
    out.explained = std::max(out.explained, 1 - regression.left_at_once(c, static_cast<int>(at) - reach));
  if (out.explained < kLeastByRotors) return std::nullopt;
  const auto k = static_cast<std::size_t>(at);
  const double bend = misfit[k - 1] - 2 * misfit[k] + misfit[k + 1], rate_hz = regression.rate_hz();
  if (!(bend > 0)) return std::nullopt;
  out.lag_s = (static_cast<double>(at) - reach + 0.5 * (misfit[k - 1] - misfit[k + 1]) / bend) / rate_hz;
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
