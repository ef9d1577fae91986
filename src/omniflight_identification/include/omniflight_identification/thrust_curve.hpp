// Thrust and torque of a rotor over its speed.
#pragma once

#include "omniflight_identification/bench_sweep.hpp"

namespace omniflight::identification {

struct Estimate {
  double value = 0.0, sigma = 0.0;
  double low() const { return value - 1.96 * sigma; }  ///< of the interval of 95 %
  double high() const { return value + 1.96 * sigma; }
};

/// load = sum over rotors of scale speed^exponent, + offset.
struct RotorCurve {
  Estimate scale;        ///< N/(rad/s)^exponent, or N m/(rad/s)^exponent
  Estimate exponent;     ///< 1
  Estimate offset;       ///< N or N m, of the whole stand
  Estimate coefficient;  ///< N/(rad/s)^2 or N m/(rad/s)^2: scale where the exponent is held at 2, with its
                         ///< own offset
  double rms = 0.0;      ///< of what the curve leaves, N or N m
  double slowest = 0.0, fastest = 0.0;  ///< rad/s, where the curve has data
};

struct ThrustCurves {
  RotorCurve thrust;
  bool has_torque = false;
  RotorCurve torque;
  Estimate drag_ratio;  ///< m, torque coefficient over thrust coefficient
  Eigen::Index rows = 0;
};

/// One curve for all sweeps (of one kind of rotor). Intervals take into account that neighbouring rows err
/// alike. Errors: speeds that span less than a fifth of the fastest, sweeps with and without torque are mixed
/// (then without), no convergence.
Result<ThrustCurves> fit_thrust_curves(const std::vector<BenchSweep>& sweeps);

/// Load of one rotor at a speed [rad/s], without the offset.
double load_at(const RotorCurve& curve, double speed_radps);

}  // namespace omniflight::identification
