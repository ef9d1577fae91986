// The failsafe ladder in the controller: which poses are believed, what is wrong, and what is flown instead
// of the plan. Time is an argument; no bus inside.
#pragma once

#include <optional>
#include <string>

#include "landing_place.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_control/state_estimator.hpp"
#include "omniflight_core/trajectory.hpp"
#include "omniflight_safety/missed_share.hpp"
#include "omniflight_safety/pose_monitor.hpp"
#include "omniflight_safety/vitals.hpp"

namespace omniflight::components {

struct GuardConfig {
  safety::LadderConfig ladder = safety::LadderConfig::standard();
  safety::Limits limits;
  safety::PoseMonitorConfig poses;
  safety::StampClockConfig imu_stamps;
  double descend_speed = 0.3;  ///< m/s
  LandingConfig landing;
};
/// mocap_timeout_s, imu_timeout_s, fence_min_m, fence_max_m, fence_margin_m, descend_speed_mps, ground_z_m,
/// ...
Result<GuardConfig> read_guard(bus::Parameters& parameters);

class FlightGuard {
 public:
  /// below: the mission's map and the vehicle; without it a descent ends at the ground.
  explicit FlightGuard(const GuardConfig& config, std::optional<MapBelow> below = {})
      : config_(config),
        poses_(config.poses),
        imu_clock_(config.imu_stamps),
        landing_(config.landing, std::move(below)) {}

  /// Flight time [s] of an inertial sample, whatever clock stamped it; false when the stamp is refused.
  /// now_s: of the newest tick.
  bool place_imu(double stamp_s, double now_s, double& flight_s);
  std::uint64_t refused_imu() const { return refused_imu_; }
  const safety::StampClock& imu_clock() const { return imu_clock_; }

  /// Whether the estimator may have this pose, as taken at poses().believed_s(). now_s: flight time.
  bool believes(double stamp_s, const Vec3& p_WB, const Quat& q_WB, double now_s, bool free,
                const control::StateEstimator& estimator);

  /// Every tick of the clock master: t [s] and the period [s] it wants to keep.
  void tick(double t, double period) { missed_.tick(t, period); }
  void battery(double voltage_V) { battery_V_ = voltage_V; }
  /// Share of their range that the rotors left after a loss at loss_s [s] need to hover. It counts from a
  /// moment after the loss on, whenever in between it is heard of: which tick acts does not depend on the
  /// bus.
  void rotors(double loss_s, double hover_load) { loss_ = {loss_s, hover_load}; }

  /// rad, of the rotors: with it a descent knows how far down the vehicle reaches.
  void tilt(double alpha) { alpha_ = alpha; }

  /// Once a tick in free flight; the first one arms the ladder. True when the action has changed.
  bool update(double now_s, const control::StateEstimator& estimator, safety::Wish wish);

  /// What is flown at this tick: the plan's reference at `along` [s], or what the action makes of it.
  Reference reference(const Trajectory& plan, double along, double now_s, const RigidState& estimate);
  /// s that the plan has stood still because of hold.
  double paused_s() const { return paused_s_; }

  safety::Action action() const { return state_.armed ? state_.action : safety::Action::fly; }
  /// "descend: pose_lost", "fly".
  std::string words() const;
  /// Where the descent ends; empty: none has begun.
  std::string landing_words() const { return descending_ ? landing_.words() : std::string(); }
  const safety::PoseMonitor& poses() const { return poses_; }

 private:
  GuardConfig config_;
  safety::PoseMonitor poses_;
  safety::StampClock imu_clock_;
  safety::MissedShare missed_;
  std::uint64_t refused_imu_ = 0;
  safety::LadderState state_;
  std::optional<Reference> frozen_;  ///< from where hold and descend go on
  LandingPlace landing_;
  bool descending_ = false;
  std::optional<double> battery_V_;
  struct {
    double at_s = 0, hover_load = 0;
  } loss_;
  double alpha_ = 0, frozen_s_ = 0, last_s_ = 0, paused_s_ = 0;
};

}  // namespace omniflight::components
