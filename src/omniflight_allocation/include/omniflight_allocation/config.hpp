// Settings of the allocator.
#pragma once

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::allocation {

/// What W1 and W3 weigh. The thesis does not say; the choice changes the conditioning by six orders of
/// magnitude.
enum class InputUnit {
  newton,  ///< u in the cost is the thrust [N]
  hz2,     ///< u in the cost is w |w| with the rotor speed w in revolutions per second [Hz^2]
};

enum class TiltMode {
  fixed,   ///< the tilt is an input
  search,  ///< equation 4.2: the best of the previous tilt and of others within a step of it
};

/// Equation 5.3: W1 grows by growth each period while the position error stays below threshold and shrinks by
/// shrink while it is above (both where it is equal), within [floor, ceiling].
struct DynamicWeights {
  bool enabled = false;
  double threshold = 0.05;  ///< m; between the sag under a lossy tilt and the sag under a good one
  double growth = 1.01;     ///< factor a period, >= 1
  double shrink = 0.9;      ///< factor a period, in (0, 1]
  double floor = 1e-9;      ///< unit of W1
  double ceiling = 1e-5;    ///< unit of W1
};

struct AllocatorConfig {
  InputUnit input_unit = InputUnit::newton;
  double w_input = 1e-8;   ///< W1, per input_unit^2: economy of rotor inputs
  double w_linear = 3e6;   ///< W2, per (m/s^2)^2
  double w_angular = 1e3;  ///< W2, per (rad/s^2)^2
  double w_rate = 1e-5;    ///< W3, per input_unit^2: change of rotor inputs from one period to the next
  TiltMode tilt_mode = TiltMode::search;
  double tilt_step = to_radians(0.3);  ///< rad a control period, search mode
  /// Tilts that a period compares, search mode, 1 to 8: the previous one, then pairs at a step below and
  /// above, at half a step, at a quarter. 3 is equation 4.2.
  int tilt_candidates = 3;
  double initial_tilt = to_radians(30.0);  ///< rad, clipped to the vehicle's limits
  DynamicWeights dynamic_weights;
  /// Keep |u| >= the vehicle's min_thrust for rotors that turn both ways too, exactly: thrusts between
  /// -min_thrust and +min_thrust are then never asked for. Others keep u >= min_thrust in any case.
  bool keep_min_thrust = false;
  double mass = 0;              ///< kg the controller believes in; 0: the vehicle's
  Mat3 inertia = Mat3::Zero();  ///< kg m^2 the controller believes in; zero: the vehicle's

  /// The two weightings compared in the thesis: A tracks first, B trades tracking for economy.
  static AllocatorConfig case_a();
  static AllocatorConfig case_b();
};

/// Checks ranges; errors name field and unit.
Status validate(const AllocatorConfig& config);

}  // namespace omniflight::allocation
