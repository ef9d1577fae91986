#include "omniflight_allocation/config.hpp"

namespace omniflight::allocation {

AllocatorConfig AllocatorConfig::case_a() { return {}; }

AllocatorConfig AllocatorConfig::case_b() {
  AllocatorConfig config;
  config.w_input = 1e-5;
  config.w_linear = 3e4;
  config.w_angular = 10;
  return config;
}

Status validate(const AllocatorConfig& c) {
  const auto refuse = [](const char* field, const char* why) {
    return bad_input(std::string(field) + " " + why, std::string("allocator.") + field,
                     "Correct the parameter");
  };
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!(c.w_input >= 0) || !std::isfinite(c.w_input))
    return refuse("w_input", "must be finite and not negative");
  if (!(c.w_rate >= 0) || !std::isfinite(c.w_rate))
    return refuse("w_rate", "must be finite and not negative");
  if (!positive(c.w_input + c.w_rate))
    return refuse("w_input", "and w_rate must not both be zero: the best inputs would not be unique");
  if (!positive(c.w_linear)) return refuse("w_linear", "must be positive, 1/(m/s^2)^2");
  if (!positive(c.w_angular)) return refuse("w_angular", "must be positive, 1/(rad/s^2)^2");
  if (!(c.tilt_step >= 0) || !std::isfinite(c.tilt_step))
    return refuse("tilt_step", "must not be negative, rad");
  if (c.tilt_candidates < 1 || c.tilt_candidates > 8) return refuse("tilt_candidates", "must be 1 to 8");
  if (!std::isfinite(c.initial_tilt)) return refuse("initial_tilt", "is not finite, rad");
  if (!(c.mass >= 0) || !std::isfinite(c.mass))
    return refuse("mass", "must be positive, or 0 for the vehicle's, kg");
  if (!c.inertia.allFinite()) return refuse("inertia", "is not finite, kg m^2");
  const DynamicWeights& d = c.dynamic_weights;
  if (!d.enabled) return {};
  if (!(d.threshold >= 0) || !std::isfinite(d.threshold))
    return refuse("dynamic_weights.threshold", "must not be negative, m");
  if (!(d.growth >= 1) || !std::isfinite(d.growth))
    return refuse("dynamic_weights.growth", "must be at least 1");
  if (!(d.shrink > 0 && d.shrink <= 1)) return refuse("dynamic_weights.shrink", "must lie in (0, 1]");
  if (!(d.floor > 0 && d.floor <= d.ceiling) || !std::isfinite(d.ceiling))
    return refuse("dynamic_weights.floor", "must be positive and at most the ceiling");
  return {};
}

}  // namespace omniflight::allocation
