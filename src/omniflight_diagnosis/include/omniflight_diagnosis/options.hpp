// What a diagnosis assumes and how strict it is.
#pragma once

#include <string>
#include <vector>

#include "omniflight_physics/situation.hpp"

namespace omniflight::diagnosis {

/// How well the numbers of the vehicle and the sensors are known: deviations below these are no finding.
/// One standard deviation each; they enter the fit as unnamed offsets with this prior.
struct Tolerance {
  double thrust_scale = 0.01;            ///< 1, thrust coefficient and mass together
  double accelerometer_lateral = 0.15;   ///< m/s^2, bias and mounting tilt
  double accelerometer_vertical = 0.05;  ///< m/s^2
  double world_force = 0.005;            ///< 1, constant force in the world over weight (level, alignment)
  double torque_trim = 0.03;             ///< 1, constant torque over weight times largest rotor arm
};

struct Options {
  physics::Environment environment;
  Tolerance tolerance;
  double cutoff_hz = 15.0;        ///< zero-phase low pass on both sides
  double effect_cutoff_hz = 5.0;  ///< low pass of the rotor speeds inside the effects, see Problem::predict
  double grid_hz = 40.0;     ///< regression grid; kept below three times the cutoff so that whitening sees no
                             ///< empty band
  int ar_order = 8;          ///< whitening
  double error_rate = 0.01;  ///< p of the entry threshold ln(m/p)
  double max_gap_s = 0.08;   ///< longer gaps in a needed signal are cut out
  double margin_s = 0.25;    ///< cut on both sides of every gap and of the ends
  double min_share = 0.04;   ///< of the residual energy of its best channel that an effect must remove
  double min_magnitude = 0.001;  ///< RMS of an effect over weight (or weight times arm)
  int max_effects = 6;
  std::vector<std::string> only;     ///< candidate ids; empty: the whole library
  std::vector<std::string> exclude;  ///< ids that are not offered
  bool rollouts = true;
};

}  // namespace omniflight::diagnosis
