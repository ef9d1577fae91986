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

/// What ordinary means of measuring leave open of numbers of which the laboratory tells no tolerance, each
/// column one standard deviation: centre of mass 2 % of the arm, moments of inertia 8 %, thrust of a rotor by
/// itself 2 %, drag torque 10 %.
std::vector<Eigen::MatrixXd> untold_columns(const FamilyVehicle& vehicle, const FlightSeries& series);

}  // namespace omniflight::proof
