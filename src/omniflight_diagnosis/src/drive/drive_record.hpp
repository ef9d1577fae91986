// What the rotors were ordered and what they did, on the steps of a simulation of the drives.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "../conditioning/commanded_drives.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// One uninterrupted stretch of flight.
struct DriveRecord {
  double step = 0;  ///< s, of the simulation
  Eigen::Index steps = 0;
  CommandTrack ordered;     ///< times after the first step begins
  std::vector<double> t;    ///< s after the first step begins, of the speeds
  Eigen::MatrixXd speed;    ///< rad/s, samples x rotors
  Eigen::MatrixXd command;  ///< rad/s, the last one at the same times
  Eigen::ArrayXX<bool>
      counts;  ///< whether a speed can be believed: a rotor that nearly stops is measured badly
  bool from_duty_cycle = false;  ///< commands are speeds that a static map gives of duty cycle and voltage

  double duration_s() const { return step * static_cast<double>(steps); }
};

/// The longest stretch of a flight, or as much of it as `most_s`. Empty where speeds or commands are missing,
/// slower than about 30 Hz, or shorter than three seconds.
std::optional<DriveRecord> drive_record(const recording::Recording& recording,
                                        const vehicle::Vehicle& vehicle, const Flight& flight, double most_s);

}  // namespace omniflight::diagnosis
