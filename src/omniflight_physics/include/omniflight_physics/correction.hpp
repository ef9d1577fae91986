// Unknown physics as a model: a force or torque along one axis that follows something smooth in the vehicle's
// own state. It is in no catalogue and no hypothesis; a diagnosis writes it beside the effects it names, and
// the simulator flies it like one of them.
#pragma once

#include <span>

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

/// A quantity of the state that a correction may follow.
struct Quantity {
  enum class Axes { body, world, both };  ///< of the force it may explain
  const char* name;                       ///< in model files: "climb_speed"
  const char *words, *unit;
  const char* variable;  ///< what it stands for: "speed"
  Axes axes;
  bool pairs;  ///< makes sense in a product with another
  double (*value)(const Situation&);
};
std::span<const Quantity> quantities();

struct Feature {
  enum class Form { product, bump, wave, pulse };
  Form form = Form::product;
  int first = 0, second = -1;       ///< product: indices into quantities(); second < 0: the first alone
  Vec3 center = Vec3::Zero();       ///< bump: m, world
  double length = 1;                ///< m; bump: standard deviation, wave: wavelength
  double direction = 0;             ///< rad; wave: horizontal, from the world's x
  double frequency = 0, phase = 0;  ///< Hz; rad, of a cosine: of pulse (in time) and wave (in place)

  double at(const Situation& s) const;
};

/// coefficient * (feature - mean) along one axis; the feature is held inside [low, high], where it was seen.
struct Correction {
  int channel = 0;     ///< 0 to 5: Fx Fy Fz [N] Mx My Mz [Nm]
  bool world = false;  ///< axes of a force; a torque is in body axes
  Feature feature;
  double coefficient = 0;  ///< N or Nm per unit of the feature
  double mean = 0, low = -1e9, high = 1e9;
};

/// As the simulator and a fit take it: only the coefficient has a derivative. Its effect is not in
/// builtin_effects().
ActiveEffect as_effect(const Correction& correction);
bool is_correction(const ActiveEffect& effect);
/// Of an effect for which is_correction holds.
Correction correction_of(const ActiveEffect& effect);

}  // namespace omniflight::physics
