// What the gateway listens to before it starts rotors, see omniflight_safety/preflight.hpp.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>

#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_planning/plan.hpp"
#include "omniflight_safety/missed_share.hpp"
#include "omniflight_safety/preflight.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::components {

/// A plan is for one vehicle; whoever starts components by hand may mix them up. folder: empty for no plan.
inline Status check_plan(const std::string& folder, const vehicle::Vehicle& vehicle) {
  if (folder.empty()) return {};
  const auto plan = planning::read_plan(folder);
  if (!plan) return Failure(plan.error());
  if (plan->certificate.vehicle_sha256 == vehicle.sha256) return {};
  return bad_input("is of another vehicle, or of other overrides, than '" + vehicle.name + "' of the gateway",
                   folder, "Plan for this vehicle, or give the plan's vehicle and vehicle_set");
}

class StartPermission {
 public:
  /// require_recorder, least_free_MB, least_battery_V, most_missed_share.
  void read(bus::Parameters& p) {
    constexpr double kMega = 1e6;
    limits_.recorder = p.flag("require_recorder", true);
    limits_.free_bytes = static_cast<std::uint64_t>(
        kMega * p.number("least_free_MB", static_cast<double>(limits_.free_bytes) / kMega, 0, 1e9));
    limits_.battery_V = p.number("least_battery_V", 0.0, 0, 1000);
    limits_.missed_share = p.number("most_missed_share", 0.05, 0, 1);
  }
  Status subscribe(const bus::Participant& participant) {
    using namespace msgs;
    auto pose = bus::Subscription<geometry_msgs::PoseStamped>::create(
        participant, topics::mocap, bus::Qos::control(),
        [this](const auto&, std::int64_t) { pose_ns_.store(now_ns()); });
    if (!pose) return Failure(pose.error());
    pose_.emplace(std::move(*pose));
    auto recorder = bus::Subscription<omniflight_msgs::RecorderState>::create(
        participant, topics::recorder, bus::Qos::control(), [this](const auto& m, std::int64_t) {
          const std::lock_guard lock(mutex_);
          recorder_file_ = bus::text(m.file);
        });
    if (!recorder) return Failure(recorder.error());
    recorder_.emplace(std::move(*recorder));
    return {};
  }
  void unsubscribe() {
    pose_.reset();
    recorder_.reset();
  }

  /// Every time that the gateway looks, at flight time now_s; it means to do so every period_s.
  void look(double now_s, double period_s) {
    if (!observed_since_s_) observed_since_s_ = now_s;
    looked_s_ = now_s;
    missed_.tick(now_s, period_s);
  }

  Status judge(std::size_t commanders, std::optional<double> battery_V) const {
    safety::Readiness found;
    found.commanders = commanders;
    found.pose_sources = pose_->peers();
    found.recorder = recorder_->peers() > 0;
    if (const std::int64_t ns = pose_ns_.load(); ns > 0)
      found.pose_age_s = 1e-9 * static_cast<double>(now_ns() - ns);
    found.battery_V = battery_V;
    constexpr double kObserved = 0.5;  // s
    if (observed_since_s_ && looked_s_ - *observed_since_s_ >= kObserved)
      found.missed_share = missed_.share();
    const std::lock_guard lock(mutex_);
    std::error_code ec;
    const auto space = std::filesystem::space(std::filesystem::path(recorder_file_).parent_path(), ec);
    if (!recorder_file_.empty() && !ec) found.free_bytes = space.available;
    return safety::preflight(limits_, found);
  }

 private:
  static std::int64_t now_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  safety::PreflightLimits limits_;
  safety::MissedShare missed_;
  std::optional<double> observed_since_s_;
  double looked_s_ = 0;
  std::atomic<std::int64_t> pose_ns_{0};  ///< CLOCK_MONOTONIC of the newest pose
  mutable std::mutex mutex_;
  std::string recorder_file_;  ///< guarded by mutex_
  std::optional<bus::Subscription<msgs::geometry_msgs::PoseStamped>> pose_;
  std::optional<bus::Subscription<msgs::omniflight_msgs::RecorderState>> recorder_;
};

}  // namespace omniflight::components
