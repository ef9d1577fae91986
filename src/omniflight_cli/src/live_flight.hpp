// A flight as the bus tells it while it is flown, for the live view.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "omniflight_bus/subscription.hpp"
#include "omniflight_view/scene.hpp"

namespace omniflight::cli {

class LiveFlight {
 public:
  /// Listens in the domain of a run.
  static Result<std::unique_ptr<LiveFlight>> join(int domain);

  /// The latest of everything, when something is new since the last call. Time [s] since the first message.
  std::optional<view::Frame> news();
  /// Positions [m] of the planned path, once after it was heard.
  std::optional<std::vector<Vec3>> new_path();

 private:
  LiveFlight() = default;
  Status listen(int domain);
  double since_first(std::int64_t ns);

  std::mutex mutex_;  // guards what follows, up to the subscriptions
  view::Frame frame_;
  std::vector<Vec3> path_;
  bool fresh_ = false, fresh_path_ = false;
  std::optional<std::int64_t> first_ns_;

  std::optional<bus::Participant> participant_;
  std::optional<bus::Subscription<msgs::omniflight_msgs::ControllerState>> controller_;
  std::optional<bus::Subscription<msgs::omniflight_msgs::RotorTelemetry>> rotors_;
  std::optional<bus::Subscription<msgs::trajectory_msgs::MultiDOFJointTrajectory>> trajectory_;
  std::optional<bus::Subscription<msgs::diagnostic_msgs::DiagnosticArray>> failsafe_, gate_;
};

}  // namespace omniflight::cli
