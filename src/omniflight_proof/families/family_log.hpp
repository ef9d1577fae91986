// Writes down what a laboratory of a family writes down, never the truth.
#pragma once

#include <map>
#include <string>

#include "family_flight.hpp"

namespace omniflight::proof {

class FamilyLog {
 public:
  /// begin: plant time [s] at which the recording starts.
  FamilyLog(const vehicle::Vehicle& vehicle, const Logging& what, double begin)
      : vehicle_(vehicle), what_(what), begin_(begin) {}
  void sensors(double now, const SensorFrame& frame);
  void reasons(double now, const Reference& reference, const ControlOutput& output,
               const std::vector<double>& speeds, const vehicle::RotorVector& thrust);
  recording::Recording finish();

 private:
  struct Column {
    std::size_t width = 0;
    std::vector<double> t, values;
  };
  bool off(double now) const;
  /// resolution: a power of ten; what a sensor or link resolves.
  void put(const char* name, double t, const double* values, std::size_t width, double resolution);
  bool due(double& next, double now, double rate) const;

  const vehicle::Vehicle& vehicle_;
  const Logging& what_;
  double begin_;
  long imu_count_ = 0;
  double next_command_ = 0, next_reference_ = 0;
  std::map<std::string, Column> columns_;
};

}  // namespace omniflight::proof
