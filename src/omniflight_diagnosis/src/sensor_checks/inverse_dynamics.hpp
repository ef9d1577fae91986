// Inverse dynamics: force and torque that the recorded motion needs, for recordings without rotor signals.
#pragma once

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// Smoothed motion on a uniform grid (100 Hz, low pass 6 Hz).
struct MotionOnGrid {
  std::vector<double> t;  ///< s
  Eigen::MatrixXd force;  ///< n x 3, specific force, m/s^2: body axes, or world axes without an attitude
  Eigen::MatrixXd w, dw;  ///< n x 3, rad/s and rad/s^2, body; empty without a gyro or an attitude
  bool in_body = false;
};
/// From accelerometer, else position; empty with neither, below 2 s or above 2 h.
std::optional<MotionOnGrid> motion_on_grid(const recording::Recording& recording, const Options& options);

/// Force and torque for the recorded motion with mass and inertia of the vehicle file, and the capacity of
/// its rotors.
struct InverseDynamics {
  double mean_N = 0, most_N = 0;  ///< mean, and 99.5 % quantile, of the force
  double rotors_N = 0;            ///< sum of max_thrust of all rotors
  double torque_Nm = 0;           ///< RMS; 0 without a gyro or an attitude
  double sideways_N = 0;          ///< RMS force normal to the common rotor axis; 0 without one_axis
  bool one_axis = false;          ///< all rotors are parallel, and the force is known in body axes
  /// Free fall: specific force below 10 % of gravity for 0.1 s
  std::vector<std::pair<double, double>> falls_s;
};

/// Of motion_on_grid(); empty where that is.
std::optional<InverseDynamics> inverse_dynamics(const recording::Recording& recording,
                                                const vehicle::Vehicle& vehicle, const Options& options);

/// As sentences of the summary, and as entries of Intake::sensors.
std::string in_words(const InverseDynamics& needed, const vehicle::Vehicle& vehicle);
std::vector<SensorFact> facts_of(const InverseDynamics& needed);

}  // namespace omniflight::diagnosis
