// The vehicles of the families: built for each case, written as a vehicle file with the nominal values.
#pragma once

#include <string>

#include "family.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

struct FamilyVehicle {
  vehicle::Vehicle nominal;
  bool fully_actuated = false;
  double servo_lag = 0, servo_backlash = 0;  ///< s, rad: the tilt servo's own, of every such vehicle
  double reach = 1;                          ///< m, half the room that it flies in
  double speed = 1, acceleration = 2;        ///< m/s, m/s^2 of its manoeuvres
  double lean = 0;                           ///< rad, attitude that a fully actuated one may ask for

  double weight() const { return nominal.mass * kGravity; }  ///< N
  double arm() const;                                        ///< m, longest
};

/// Draws one; errors are those of a vehicle that is not valid.
Result<FamilyVehicle> draw_vehicle(const Coordinates& where, BoxRandom& random);

/// The vehicle file. servo_told: with time_constant_s and backlash_deg of the tilt servo.
std::string vehicle_yaml(const FamilyVehicle& vehicle, bool servo_told);

}  // namespace omniflight::proof
