#include "omniflight_planning/time_optimal.hpp"

#include <algorithm>
#include <cmath>

#include "path_limits.hpp"

namespace omniflight::planning {

SpeedProfile::SpeedProfile(double length, const std::vector<double>& squares)
    : t_{0.0}, u_{0.0}, du_{0.0}, sum_{0.0} {
  const double step = length / static_cast<double>(squares.size() - 1);
  for (std::size_t i = 1; i < squares.size(); ++i) {
    const double v0 = du_.back(), v1 = std::sqrt(squares[i]), dt = 2.0 * step / (v0 + v1);
    sum_.push_back(sum_.back() + dt * (u_.back() + dt * (v0 / 2.0 + (v1 - v0) / 6.0)));
    t_.push_back(t_.back() + dt);
    u_.push_back(step * static_cast<double>(i));
    du_.push_back(v1);
  }
}

SpeedProfile::Moment SpeedProfile::at(double t) const {
  if (t <= 0.0) return {0.0, 0.0, 0.0};
  if (t >= duration()) return {sum_.back() + (t - duration()) * u_.back(), u_.back(), 0.0};
  const auto k = static_cast<std::size_t>(std::upper_bound(t_.begin(), t_.end(), t) - t_.begin()) - 1;
  const double dt = t - t_[k], a = (du_[k + 1] - du_[k]) / (t_[k + 1] - t_[k]);
  return {sum_[k] + dt * (u_[k] + dt * (du_[k] / 2.0 + dt * a / 6.0)), u_[k] + dt * (du_[k] + dt * a / 2.0),
          du_[k] + dt * a};
}

SpeedProfile::Law SpeedProfile::averaged(double t, double width) const {
  const Moment now = at(t), before = at(t - width);
  return {(now.sum - before.sum) / width, (now.u - before.u) / width, (now.du - before.du) / width};
}

Result<SpeedProfile> time_optimal(const PoseCurve& curve, const allocation::RotorLoad& rotors,
                                  const MotionLimits& limits, int steps, const Deadline& deadline) {
  const auto places = PathLimits::create(curve, rotors, limits, steps, deadline);
  if (!places) return Failure(places.error());
  return places->fastest(std::vector<double>(static_cast<std::size_t>(steps) + 1, 1.0));
}

}  // namespace omniflight::planning
