// Commands and speeds of one stretch of flight, prepared for simulation of the drives.
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
  CommandTrack ordered;          ///< rad/s; times [s] from the first step on
  std::vector<double> t;         ///< s from the first step on, of the speed samples
  Eigen::MatrixXd speed;         ///< rad/s, samples x rotors
  Eigen::MatrixXd command;       ///< rad/s, last command at the same times, samples x rotors
  Eigen::ArrayXX<bool> counts;   ///< samples x rotors, used: not slower than a quarter of the median speed
  bool from_duty_cycle = false;  ///< commands are a static map of duty cycle and voltage

  double duration_s() const { return step * static_cast<double>(steps); }
};

/// The longest segment of the flight, at most its first most_s [s]. Empty where speeds or commands are
/// missing, sampled below 33 Hz, interrupted for more than 0.1 s, or shorter than 3 s.
std::optional<DriveRecord> drive_record(const recording::Recording& recording,
                                        const vehicle::Vehicle& vehicle, const Flight& flight, double most_s);

}  // namespace omniflight::diagnosis
