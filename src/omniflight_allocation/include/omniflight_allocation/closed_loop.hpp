// A rigid body under PD control and allocation: just enough to ask which weights survive a thrust mismatch
// (thesis, chapters 5.3 and 6). The plant has no motor lag; its tilt follows at once, its thrust can be
// scaled against what the allocator believes.
#pragma once

#include <functional>
#include <vector>

#include "omniflight_allocation/config.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

struct LoopGains {
  double kp1 = 25, kp2 = 300;    ///< 1/s, 1/s^2
  double kr1 = 24.5, kr2 = 150;  ///< 1/s, 1/s^2
};

/// One control period.
struct LoopSample {
  double t = 0;               ///< s
  double position_error = 0;  ///< m
  double angle_error = 0;     ///< rad
  double alpha = 0;           ///< rad
  double w_input = 0;         ///< W1 that was used, per input_unit^2
};

struct LoopResult {
  bool failed = false;                        ///< more than 2 m from its reference
  double end = 0;                             ///< s, of the last period
  double worst_error = 0;                     ///< m
  double last_error = 0;                      ///< m
  double mean_error = 0;                      ///< m
  double mean_power = 0;                      ///< W, drag torque times speed
  double worst_angle = 0;                     ///< rad
  double tilt_low = HUGE_VAL, tilt_high = 0;  ///< rad
  std::vector<LoopSample> samples;            ///< every period
};

/// Smooth step from 0 to 1 over [0, 1] with its first two derivatives (quintic).
Vec3 quintic(double x);

/// Hover 2 s, move by (0.5, 0.4, 0) m in 2 s, hover 2 s, pitch to 90 deg in pitch_time [s], hold 2 s, back,
/// hold 2 s. The thesis names no trajectory; this one was chosen here.
Reference thesis_reference(double t, double pitch_time);

/// Hover 2 s, turn once about body x on the spot in roll_time [s], hold 1 s: the motion lasts roll_time + 3
/// s.
Reference roll_reference(double t, double roll_time);

using Motion = std::function<Reference(double t)>;

/// Control at 100 Hz (thesis eq. 4.1), plant at 400 Hz. thrust_scale: share of the believed thrust at a tilt
/// [rad]. tilt: rad over time, flown in fixed mode; nothing: as the config has it. The vehicle and config
/// must be valid; a vehicle that the allocator refuses counts as failed at once.
LoopResult fly(const vehicle::Vehicle& v, const AllocatorConfig& config, const Motion& motion,
               double duration, const std::function<double(double alpha)>& thrust_scale,
               const LoopGains& gains = {}, const std::function<double(double t)>& tilt = {});

/// The pitch of thesis_reference(), until [s] at most.
LoopResult fly(const vehicle::Vehicle& v, const AllocatorConfig& config, double pitch_time,
               const std::function<double(double alpha)>& thrust_scale, const LoopGains& gains = {},
               double until = HUGE_VAL);

}  // namespace omniflight::allocation
