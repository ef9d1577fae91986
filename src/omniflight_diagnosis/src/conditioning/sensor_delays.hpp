// What comes late: the clock of the board, the filter of its inertial sensor, or thrust.
#pragma once

#include <optional>

#include "thrust_response.hpp"
#include "torque_alignment.hpp"

namespace omniflight::diagnosis {

/// Delays of the gyro behind the pose and behind the rotor speeds; whatever was not measured is empty.
struct GyroDelays {
  std::optional<Alignment> behind_pose;    ///< "attitude" and "gyro", lag_s positive where the gyro is late
  std::optional<TorqueLag> behind_rotors;  ///< as a delay
  std::optional<ThrustResponse> as_response;  ///< and as a response, where that is likelier
};

/// clock_offset (late behind the pose alone), sensor_filter (behind both) or dynamic_inflow (behind the
/// rotors alone), whichever is likeliest, with those as rivals that are behind it by less than 3 nat. Each
/// predicts both delays from one, of which 0.03 s is the prior deviation; clocks may be off by their
/// tolerances. Empty where nothing late is as likely.
std::optional<SensorFault> what_is_late(const GyroDelays& delays, const vehicle::Vehicle& vehicle,
                                        const Options& options);

}  // namespace omniflight::diagnosis
