// Which of two sensors sits away from the body origin, and accelerations freed of what sensors add.
#pragma once

#include "kinematics.hpp"
#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

/// Kinematics tell where the inertial sensor lies in the body that motion capture follows, not which of the
/// two is away from the origin of the vehicle. The forces tell: an accelerometer off the origin adds
/// m (w' x r + w x (w x r)) [N, body] to what they leave. Where they do not add it, imu_lever_arm becomes
/// mocap_offset, by -r; where they cannot tell, each is named as well as the other.
void attribute_lever(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& options,
                     Kinematics& kinematics);

/// Gives the flight the accelerations that a faultless accelerometer at the body origin would have measured.
void compensate(const Kinematics& kinematics, Flight& flight);

}  // namespace omniflight::diagnosis
