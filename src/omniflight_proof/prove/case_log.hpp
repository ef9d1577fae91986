// Collects what a flight of the proof leaves behind: measured and computed signals, never the truth.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_proof/sensors.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

/// Numbers are rounded to what the sensor or link resolves, times to microseconds, so that files stay small
/// and no digit tells which plant they are from.
class Log {
 public:
  explicit Log(const vehicle::Vehicle& vehicle) : rotors_(static_cast<std::size_t>(vehicle.rotor_count())) {}
  void sensors(const SensorFrame& frame);
  /// What goes to the rotors, every control period.
  void command(double t, const std::vector<double>& speeds, double alpha);
  /// What controller and allocator thought, less often.
  void reasons(double t, const Reference& reference, const Vec6& demand, const Vec6& achieved,
               const vehicle::RotorVector& thrust);
  /// The recording; its clock starts at the first sample.
  recording::Recording finish();

 private:
  struct Column {
    std::size_t width = 0;
    std::vector<double> t, values;
  };
  void put(const char* name, double t, const double* values, std::size_t width, double resolution);
  std::size_t rotors_;
  std::map<std::string, Column> columns_;
};

}  // namespace omniflight::proof
