// What is believed of an effect before any flight was seen: how often it occurs, and of which size its
// parameters are on a vehicle of this size.
#pragma once

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

/// Characteristic sizes of a vehicle in hover; they make the parameters of all effects dimensionless.
struct VehicleSize {
  double mass = 1;                  ///< kg
  double weight = 1;                ///< N
  double arm = 1;                   ///< m, largest distance of a rotor from the body origin
  double disc = 1;                  ///< m^2, of a circle around all rotors
  double rotor_thrust = 1;          ///< N, of one rotor in hover
  double rotor_speed = 1;           ///< rad/s, of one rotor in hover
  double speed_sum = 1;             ///< rad/s, of all rotors in hover
  Mat3 inertia = Mat3::Identity();  ///< kg m^2
};
VehicleSize size_of(const vehicle::Vehicle& vehicle, double gravity = kGravity);

/// Prior density of one parameter.
struct ParameterPrior {
  enum class Law {
    normal,       ///< N(center, scale^2)
    half_normal,  ///< the same beyond the center only: physics gives the sign
    log_normal    ///< ln(theta / center) ~ N(0, scale^2)
  };
  Law law = Law::normal;
  double center = 0;                   ///< in the parameter's unit
  double scale = 1;                    ///< in the parameter's unit; of a log-normal law in natural logarithms
  double lower = -1e18, upper = 1e18;  ///< the catalogue's bounds

  /// Parameter at the standardised coordinate u ~ N(0, 1), and its derivative there.
  double value(double u) const;
  double slope(double u) const;
  double coordinate(double theta) const;
};
ParameterPrior prior_of(const Effect& effect, std::size_t parameter, const VehicleSize& size);

/// Relative rate at which the effect is left out of models of real vehicles; 1 is ordinary.
double occurrence(const EffectInfo& info);

/// True when the effect is nothing at this parameter's neutral value whatever the others are.
bool is_amplitude(const Parameter& parameter);

}  // namespace omniflight::physics
