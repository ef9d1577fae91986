// The servo that tilts the rotors: a first-order lag of limited rate, and the play of its linkage.
#pragma once

#include <algorithm>
#include <cmath>

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::physics {

/// d servo/dt = (command - servo) / time_constant within +-rate; the rotors rest while |alpha - servo| is
/// below half the backlash, and are carried along beyond (play operator). The range of the tilt is that of
/// the commands and not kept here.
class TiltServo {
 public:
  /// At rest at `alpha` [rad], in the middle of its play.
  TiltServo(const vehicle::Tilt& tilt, double alpha)
      : time_constant_(tilt.time_constant),
        rate_(tilt.rate),
        half_play_(0.5 * tilt.backlash),
        servo_(alpha),
        alpha_(alpha) {}

  /// Goes on for dt [s] with a command [rad] that rests meanwhile; exact where the rate does not limit.
  void step(double command, double dt) {
    double move = command - servo_;
    if (time_constant_ > 0) move *= -std::expm1(-dt / time_constant_);
    const bool at_once = time_constant_ <= 0 && !(rate_ > 0);
    servo_ = at_once ? command : servo_ + (rate_ > 0 ? std::clamp(move, -rate_ * dt, rate_ * dt) : move);
    alpha_ = std::clamp(alpha_, servo_ - half_play_, servo_ + half_play_);
  }

  double alpha() const { return alpha_; }  ///< rad, of the rotors

 private:
  double time_constant_, rate_, half_play_;
  double servo_, alpha_;  ///< rad
};

}  // namespace omniflight::physics
