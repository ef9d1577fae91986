// From rotor command to rotor speed: first-order lag and transport delay, a board each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

struct ActuationFit {
  int board = 0;
  double lag_s = 0, lag_se = 0;      ///< first-order time constant
  double delay_s = 0, delay_se = 0;  ///< pure delay
  double shared_s = 0;  ///< all boards are later by this as well: delay or clock, nobody can tell
  double nominal_lag_s = 0;
  double explained = 0;  ///< share of the speed's variance
  double rms_nominal = 0,
         rms_fitted = 0;  ///< rad/s, of the speed: with the vehicle's lag and no delay, and fitted
  bool from_pwm = false;  ///< the command is a duty cycle; a gain with battery voltage is fitted along
};

/// Output-error fit per board in blocks of some seconds: the scatter of the blocks gives the standard errors.
/// Empty where speeds or commands are missing or too little moves.
std::vector<ActuationFit> fit_actuation(const recording::Recording& recording,
                                        const vehicle::Vehicle& vehicle, const Flight& flight);

/// What a flight says of a delay that all boards share and that may be the clock of its speeds; empty if none
/// is seen.
std::string on_shared_delay(const std::vector<ActuationFit>& fits);

/// Findings motor_lag and transport_delay where they differ clearly from the vehicle, with their mismatch and
/// the effects for the model.
void add_actuation(const std::vector<std::vector<ActuationFit>>& flights, Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
