// Gains of a motor's speed loop, from what was identified.
#pragma once

#include <complex>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::identification {

/// u = kp e + ki int(e) + kd N s / (s + N) e, in sampled form: the integral and the filter step backward
/// (Euler). Units: command per rad/s, command per rad, command per rad/s2, 1/s.
struct PidnGains {
  double kp = 0.0, ki = 0.0, kd = 0.0, n = 0.0;
};

/// gain / (lag s + 1) exp(-delay s) behind a hold of one control period.
struct LagPlant {
  double gain = 0.0;  ///< rad/s per unit of command
  double lag_s = 0.0, delay_s = 0.0;
};

struct Margins {
  double max_sensitivity = 0.0;  ///< largest |1 / (1 + L)|; below 2 is robust
  double gain_margin = 0.0;      ///< factor
  double phase_margin_rad = 0.0;
  double delay_margin_s = 0.0;   ///< further delay that the loop survives
  double crossover_radps = 0.0;  ///< highest frequency with |L| = 1
  bool stable = false;           ///< by simulation over 200 lags
};

struct TuningOptions {
  double control_period_s = 0.001;  ///< of the speed loop
  double max_sensitivity = 1.7;     ///< allowed over all plants (Astrom and Hagglund 2006: 1.4 to 2)
  double gain_spread = 0.2;         ///< plants with this much more and less gain are kept stable as well
};

struct Tuning {
  PidnGains gains;
  Margins nominal, worst;      ///< worst: of the least favourable plant, field by field
  double closed_loop_s = 0.0;  ///< time constant that was asked for
  double overshoot = 0.0;      ///< share of a step of the set point, nominal plant
  double rise_s = 0.0;         ///< s, to 90 %
};

/// Whether tune_pidn() takes these: plants and options in range. Errors name the field.
Status check(const std::vector<LagPlant>& plants, const TuningOptions& options);

/// Controller at exp(i w T).
std::complex<double> response(const PidnGains& gains, double period_s, double w_radps);
/// Sampled plant at exp(i w T), hold and fractional delay exact.
std::complex<double> response(const LagPlant& plant, double period_s, double w_radps);
Margins margins(const PidnGains& gains, const LagPlant& plant, double period_s);
/// Speed after a unit step of the set point at t = 0, a sample a control period.
std::vector<double> closed_loop_step(const PidnGains& gains, const LagPlant& plant, double period_s,
                                     int samples);

/// SIMC gains (Skogestad 2003; derivative of a third of the delay, Grimholt and Skogestad 2012) for the
/// fastest closed loop whose sensitivity stays within max_sensitivity for every plant and its gain spread.
/// The delay that the gains are made for includes half a control period (hold). Errors: fields out of range;
/// no gains keep the margins.
Result<Tuning> tune_pidn(const std::vector<LagPlant>& plants, const TuningOptions& options = {});

/// What given gains come to for these plants: margins, step; closed_loop_s stays 0. Errors as check().
Result<Tuning> assessed(const PidnGains& gains, const std::vector<LagPlant>& plants,
                        const TuningOptions& options = {});

}  // namespace omniflight::identification
