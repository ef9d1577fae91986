// A recording as the textbook methods see it: wrench residual and regressors on one grid. Written for the
// proof from the published equations, apart from the project's own effect library and diagnosis.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::proof {

/// One term of the library: a group of columns under one name.
struct Term {
  std::string id, stage;
  std::vector<std::string> parameters;  ///< one a column
  int first = 0;                        ///< of its columns
  int columns() const { return static_cast<int>(parameters.size()); }
};

struct BaselineData {
  int n = 0;                             ///< samples
  double period = 0;                     ///< s
  Eigen::MatrixXd residual;              ///< n x 6: N and N m, body; what rotors and inertia do not explain
  std::vector<Eigen::MatrixXd> columns;  ///< n x 6 each: wrench for a parameter of one
  std::vector<Term> terms;
  Eigen::MatrixXd features;           ///< n x k: height, velocity, rates, tilt, thrust ... for a black box
  Vec3 tracking_rmse = Vec3::Zero();  ///< m an axis
  std::string flight;                 ///< told by the reference: which flights are of one kind
};

/// Grid of 40 Hz, the same zero-phase low pass of 10 Hz on both sides. use_commands: rotor speeds are not
/// measured but taken from the commands through the nominal lag. Errors name the missing signal.
Result<BaselineData> prepare_baseline(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                                      bool use_commands = false);

}  // namespace omniflight::proof
