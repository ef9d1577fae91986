// What the motion asks of a vehicle whose mass and inertia are known, when nobody recorded its rotors.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// A smoothed motion on a regular grid.
struct MotionOnGrid {
  std::vector<double> t;  ///< s
  Eigen::MatrixXd force;  ///< n x 3, specific force, m/s^2: body axes, or world axes without an attitude
  Eigen::MatrixXd w, dw;  ///< n x 3, rad/s and rad/s^2, body; empty without a gyro or an attitude
  bool in_body = false;
};
std::optional<MotionOnGrid> motion_on_grid(const recording::Recording& recording, const Options& options);

/// Force and torque that the recorded motion needs, with what the rotors of the file could give.
struct InverseDynamics {
  double mean_N = 0, most_N = 0;  ///< over the flight, and its 99.5 % quantile
  double rotors_N = 0;            ///< all at their limit, in one direction
  double torque_Nm = 0;           ///< RMS; 0 without a gyro or an attitude
  double sideways_N = 0;          ///< RMS across the axis of rotors that all point one way, else 0
  bool one_axis = false;          ///< they do, and the attitude is known
  std::vector<std::pair<double, double>> falls_s;  ///< free fall: less than a tenth of gravity
};

/// From the accelerometer, else from the pose; nothing with neither, or less than two seconds of it.
std::optional<InverseDynamics> inverse_dynamics(const recording::Recording& recording,
                                                const vehicle::Vehicle& vehicle, const Options& options);

std::string in_words(const InverseDynamics& needed, const vehicle::Vehicle& vehicle);
std::vector<SensorFact> facts_of(const InverseDynamics& needed);

}  // namespace omniflight::diagnosis
