// Which estimator the controller runs, from its parameters.
#pragma once

#include <memory>

#include "omniflight_bus/parameters.hpp"
#include "omniflight_control/error_state_filter.hpp"
#include "omniflight_control/estimator.hpp"

namespace omniflight::components {

/// estimator: fixed_gain (estimator_*) or error_state (filter_*).
inline Result<std::unique_ptr<control::StateEstimator>> read_estimator(bus::Parameters& p) {
  const std::string name = p.text("estimator", "fixed_gain");
  control::EstimatorConfig e;
  e.position_bandwidth = p.number("estimator_position_bandwidth_radps", e.position_bandwidth, 0.1, 500);
  e.attitude_bandwidth = p.number("estimator_attitude_bandwidth_radps", e.attitude_bandwidth, 0.1, 500);
  e.gyro_bias_gain = p.number("estimator_gyro_bias_gain", e.gyro_bias_gain, 0, 1000);
  control::ErrorStateConfig f;
  f.accelerometer_noise =
      p.number("filter_accelerometer_noise_mps2_per_sqrt_hz", f.accelerometer_noise, 1e-6, 10);
  f.gyro_noise = p.number("filter_gyro_noise_radps_per_sqrt_hz", f.gyro_noise, 1e-7, 10);
  f.accelerometer_walk = p.number("filter_accelerometer_walk_mps2_per_sqrt_s", f.accelerometer_walk, 0, 10);
  f.gyro_walk = p.number("filter_gyro_walk_radps_per_sqrt_s", f.gyro_walk, 0, 10);
  f.position_noise = p.number("filter_position_noise_m", f.position_noise, 1e-6, 1);
  f.attitude_noise = p.number("filter_attitude_noise_rad", f.attitude_noise, 1e-6, 1);
  f.gate = p.number("filter_gate", f.gate, 1, 1e6);
  if (name == "fixed_gain") return {std::make_unique<control::Estimator>(e)};
  if (name == "error_state") return {std::make_unique<control::ErrorStateFilter>(f)};
  return bad_input("is '" + name + "', neither fixed_gain nor error_state", "controller.estimator",
                   "Give one of them");
}

}  // namespace omniflight::components
