// One flight of a family: own controller on the independent plant, in one process, recorded as that
// laboratory does.
#pragma once

#include <functional>
#include <vector>

#include "family_control.hpp"
#include "family_path.hpp"
#include "omniflight_proof/sensors.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::proof {

struct Gap {
  double from, until;  ///< s of the recording
};

/// What is written down of a flight.
struct Logging {
  bool imu = true, speed = true, command = true, duty = false, reference = true, reasons = false,
       battery = false;
  bool commanded_attitude = false;  ///< ref_attitude is what the position loop asks for, not that of the plan
  int imu_every = 1;                ///< of the IMU samples
  double duty_exponent = 2;         ///< thrust ~ duty^exponent
  double command_hz = 125, reference_hz = 50;
  std::vector<Gap> gaps = {};  ///< nothing is recorded
};

struct FamilyFlight {
  FamilyVehicle vehicle;
  World world;
  SensorConfig sensors;
  Path path;
  double lead = 0;  ///< s that are flown before the recording begins
  ControllerSetup flown, told;
  Logging logging;
  double step = 0.002;  ///< s, of plant and controller
  std::uint64_t seed = 1;
  bool record = true;   ///< false: only the measures below
  bool series = false;  ///< keep what an oracle needs
};

/// Of the flight behind the recording, at kSeriesRate.
struct FlightSeries {
  std::vector<Vec6> wrench;   ///< N, N m body, beyond the nominal vehicle
  std::vector<Vec6> command;  ///< N, N m: thrusts less those that commands and the nominal lag give
  std::vector<RigidState> state;
  std::vector<Vec3> specific_force, angular_acceleration;
  std::vector<vehicle::RotorVector> speed;
  std::vector<double> alpha;
};
inline constexpr double kSeriesRate = 50;  ///< Hz

struct FamilyFlown {
  recording::Recording recording;
  std::array<double, 6> wrench{}, mean{};  ///< N, N m RMS and mean: beyond the nominal vehicle
  std::array<double, 6> command{};         ///< RMS of thrusts less what commands and the nominal lag give
  std::array<double, 6> control{};         ///< of demands times mass and inertia: flown less told controller
  double specific_force = 0;               ///< m/s^2 RMS
  double rate = 0, rate_change = 0;        ///< rad/s, rad/s^2 RMS
  double lever = 0;                        ///< 1/s^2 RMS of (dw x + w x w x) per axis
  double jerk = 0, rate_jerk = 0;          ///< m/s^3, rad/s^3 RMS, of what is slower than 5 Hz
  double speed = 0;                        ///< m/s RMS
  double thrust = 0, thrust_rate = 0;      ///< N, N/s RMS of one rotor
  double lowest_thrust = 1e300;            ///< N
  double tracking = 0;                     ///< m RMS
  FlightSeries series;
};

/// Fails (incomplete) when the vehicle is lost.
Result<FamilyFlown> fly(const FamilyFlight& flight);

}  // namespace omniflight::proof
