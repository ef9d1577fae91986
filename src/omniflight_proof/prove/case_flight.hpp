// One flight of the proof: the controller and allocator of the project on the independent plant, in one
// process.
#pragma once

#include <array>
#include <functional>

#include "case_path.hpp"
#include "omniflight_allocation/config.hpp"
#include "omniflight_control/controller.hpp"
#include "omniflight_proof/sensors.hpp"
#include "omniflight_proof/world.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

struct FlightSetup {
  World world;
  SensorConfig sensors;
  Path path;
  control::ControllerConfig flown;  ///< gains that fly
  control::ControllerConfig told;   ///< gains that the recording's user knows
  std::uint64_t seed = 1;
  bool record = true;  ///< false: only the measures below
};

struct Flown {
  recording::Recording recording;
  std::array<double, 6> wrench{};    ///< N, N m RMS, body: beyond nominal, whole flight
  std::array<double, 6> variance{};  ///< N^2, (N m)^2: the same without its mean
  std::array<double, 6> command{};  ///< the same of thrusts: true less what commands and the nominal lag give
  std::array<double, 6> control{};  ///< of demands times mass and inertia: flown less told gains
  double dw = 0;                    ///< rad/s^2 RMS of the angular acceleration
  double position_rms = 0;          ///< m, tracking error
  double lowest_thrust = 1e300;     ///< N, of the commands: reversing rotors step
  double saturated = 0;             ///< share of periods with a rotor at its limit
};

/// Gains that fly well; every case varies them.
control::ControllerConfig usual_gains();

/// One second held, then path.duration of free flight at 500 Hz plant and 250 Hz control steps. Fails
/// (incomplete) when the flight is lost: more than 0.6 m off, or upset.
Result<Flown> fly(const vehicle::Vehicle& vehicle, const FlightSetup& setup);

}  // namespace omniflight::proof
