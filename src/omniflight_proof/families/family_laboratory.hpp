// The laboratory of a case: sensors, turbulence, calibration, gains and what the operator writes down of
// them.
#pragma once

#include "family_flight.hpp"

namespace omniflight::proof {

/// One standard deviation each; zero where the calibration is exact.
struct Calibration {
  double thrust_scale = 0;   ///< of the weight
  double level = 0;          ///< rad of the world, that is of the weight
  double trim = 0;           ///< of weight times arm
  double accelerometer = 0;  ///< m/s^2
  double gyro = 0;           ///< rad/s
};

struct Laboratory {
  FamilyFlight flight;  ///< nominal: nothing hidden
  Calibration calibration;
  SensorConfig told_sensors;  ///< what the operator believes
  Turbulence told_turbulence;
  bool noise_told = true;
  std::array<double, 6> sensor_noise{};  ///< N, N m RMS, see residual_noise()
  std::vector<std::string> present;      ///< what is really there and may be named
};

/// Draws it. decoy: of a nominal case, or empty.
Laboratory draw_laboratory(const Coordinates& where, const FamilyVehicle& vehicle, const std::string& decoy,
                           double vigour, BoxRandom& random);
/// What a calibration leaves, put into the world.
void leave_uncalibrated(Laboratory& laboratory, BoxRandom& random);
/// RMS of force and torque residual that sensor noise alone leaves in blocks of 20 ms (with an accelerometer)
/// or 100 ms (from the pose).
std::array<double, 6> residual_noise(const FamilyFlight& flight, const Coordinates& where);
std::string told_yaml(const Laboratory& laboratory, const Coordinates& where);

}  // namespace omniflight::proof
