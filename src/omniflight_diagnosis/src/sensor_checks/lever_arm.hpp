// Attribution of a lever arm to accelerometer or motion capture, and compensation of accelerometer errors.
#pragma once

#include "kinematics.hpp"
#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Kinematics give the position r of the accelerometer relative to the tracked point, not which of the two is
/// off the body origin. An accelerometer off the origin adds m (dw x r + w x (w x r)) [N, body] to the force
/// residual. Where that term is absent, imu_lever_arm becomes mocap_offset with -r; where it is undecided (2
/// standard errors), the other one is added as a rival.
void attribute_lever(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& options,
                     Kinematics& kinematics);

/// Subtracts the found bias and lever-arm acceleration from the accelerations of the flight.
void compensate(const Kinematics& kinematics, Flight& flight);

}  // namespace omniflight::diagnosis
