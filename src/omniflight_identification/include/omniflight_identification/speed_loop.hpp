// A motor under its speed loop, simulated: what gains do before they are flown.
#pragma once

#include <Eigen/Dense>
#include <cstdint>

#include "omniflight_identification/pidn.hpp"

namespace omniflight::identification {

struct SpeedLoop {
  LagPlant up, down;  ///< while the speed rises and falls; one gain and one delay, those of `up`
  double control_period_s = 0.001;
  double noise_radps = 0.0;  ///< rms of the measured speed, white
  double command_max = 0.0;  ///< the command stays within 0 and this; 0: no limits
  std::uint64_t seed = 1;
};

struct LoopScore {
  double mean_error = 0.0, max_error = 0.0;  ///< |set point - speed| [rad/s]
  bool bounded = true;                       ///< false: the speed ran away
};

/// Speed [rad/s], a row a control period, from rest at set_point(0). Integral action stands still at the
/// limits.
Eigen::VectorXd simulated(const SpeedLoop& loop, const PidnGains& gains,
                          const Eigen::VectorXd& set_point_radps);
LoopScore score(const Eigen::VectorXd& set_point_radps, const Eigen::VectorXd& speed_radps);

}  // namespace omniflight::identification
