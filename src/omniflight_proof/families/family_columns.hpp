// Textbook laws evaluated along a flight that is known without noise: what an oracle holds against what is
// hidden. Written for the proof from the published equations, apart from the project's effect library.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "family_flight.hpp"

namespace omniflight::proof {

/// A law with its numbers: one column a number, stacked samples of Fx ... Mz.
struct ColumnGroup {
  std::string id;
  std::vector<Eigen::MatrixXd> columns;  ///< n x 6 each: wrench of a unit of the number
};

std::vector<ColumnGroup> textbook_columns(const FamilyVehicle& vehicle, const FlightSeries& series);
/// What a calibration leaves open, each column the wrench of one standard deviation.
std::vector<Eigen::MatrixXd> calibration_columns(const FamilyVehicle& vehicle, const FlightSeries& series,
                                                 double thrust_scale, double level, double trim,
                                                 double accelerometer);

}  // namespace omniflight::proof
