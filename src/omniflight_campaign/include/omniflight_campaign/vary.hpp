// What differs from one flight of a campaign to the next, drawn at random: values of effects, the start,
// gains.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "omniflight_control/controller.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_physics/effect.hpp"

namespace omniflight::campaign {

/// How a value is drawn.
struct Distribution {
  enum class Kind { uniform, normal } kind = Kind::uniform;
  double a = 0, b = 1;                  ///< uniform: from a to b; normal: mean a, standard deviation b
  double least = -1e300, most = 1e300;  ///< a normal value outside is drawn again (truncated normal)
};

/// One varied parameter. All are drawn independently of one another.
struct Varied {
  /// effect: the value itself. start: added to where the flight begins. gain: factor of all three axes.
  enum class Of { effect, start, gain } of = Of::effect;
  std::string name;       ///< in results and plots
  std::string unit;       ///< of the drawn value
  std::string effect;     ///< id in the library
  std::string parameter;  ///< of the effect; x y z [m], roll pitch yaw [rad] of the start; kp kv ki kR kw kI
  Distribution distribution;
};

/// True when an effect can change a flight that has neither sensors nor an estimator.
bool acts_without_sensors(const physics::Effect& effect);

/// Checks names, bounds and units of what is varied, and fills in the unit. `where` leads its errors.
Status check(Varied& varied, const std::string& where);

/// One value a varied parameter, the same for a seed and name whatever else is varied and however many fly.
std::vector<double> draw(std::span<const Varied> varied, std::uint64_t seed);

/// The model with the drawn values: an effect that it has not is added, its other parameters neutral.
physics::Model with_values(const physics::Model& model, std::span<const Varied> varied,
                           std::span<const double> values);
/// The start with the drawn offsets; attitude offsets are rotations about the body's axes.
RigidState start_with(const RigidState& start, std::span<const Varied> varied,
                      std::span<const double> values);
/// The gains with the drawn factors.
control::ControllerConfig gains_with(const control::ControllerConfig& gains, std::span<const Varied> varied,
                                     std::span<const double> values);

}  // namespace omniflight::campaign
