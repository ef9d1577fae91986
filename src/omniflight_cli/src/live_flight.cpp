#include "live_flight.hpp"

#include "omniflight_components/topics.hpp"

namespace omniflight::cli {
namespace {

namespace topics = components::topics;
using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::omniflight_msgs::ControllerState;
using msgs::omniflight_msgs::RotorTelemetry;
using msgs::trajectory_msgs::MultiDOFJointTrajectory;

Vec3 vec(const double (&x)[3]) { return {x[0], x[1], x[2]}; }

/// A subscription into its place; errors of the bus as they are.
template <class T, class Take>
Status listen_to(std::optional<bus::Subscription<T>>& into, const bus::Participant& participant,
                 const char* topic, const bus::Qos& qos, Take take) {
  auto made = bus::Subscription<T>::create(participant, topic, qos, std::move(take));
  if (!made) return Failure(made.error());
  into.emplace(std::move(*made));
  return {};
}

std::string words_of(const DiagnosticArray& m) {
  const auto statuses = bus::view(m.status);
  return statuses.empty() ? std::string() : std::string(bus::text(statuses[0].message));
}

}  // namespace

Result<std::unique_ptr<LiveFlight>> LiveFlight::join(int domain) {
  std::unique_ptr<LiveFlight> flight(new LiveFlight());
  if (auto ok = flight->listen(domain); !ok) return Failure(ok.error());
  return flight;
}

double LiveFlight::since_first(std::int64_t ns) {
  if (!first_ns_ || ns < *first_ns_) first_ns_ = ns;
  return 1e-9 * static_cast<double>(ns - *first_ns_);
}

Status LiveFlight::listen(int domain) {
  auto participant = bus::Participant::create(domain);
  if (!participant) return Failure(participant.error());
  participant_ = *participant;
  const bus::Qos stream = bus::Qos::sensor_data(), latched = bus::Qos::latched_last(4);
  Status ok = listen_to(
      controller_, *participant, topics::controller, stream, [this](const ControllerState& m, std::int64_t) {
        const std::lock_guard lock(mutex_);
        frame_.t = since_first(bus::nanoseconds(m.header.stamp));
        frame_.p_WB = vec(m.est_position);
        frame_.q_WB = Quat(m.est_attitude[0], m.est_attitude[1], m.est_attitude[2], m.est_attitude[3]);
        frame_.p_WR = vec(m.ref_position);
        fresh_ = true;
      });
  if (ok)
    ok = listen_to(rotors_, *participant, topics::rotors, stream,
                   [this](const RotorTelemetry& m, std::int64_t) {
                     const auto speeds = bus::view(m.velocity);
                     const std::lock_guard lock(mutex_);
                     frame_.rotor_speed.assign(speeds.begin(), speeds.end());
                     frame_.alpha = m.alpha;
                     fresh_ = true;
                   });
  if (ok)
    ok = listen_to(trajectory_, *participant, topics::trajectory, latched,
                   [this](const MultiDOFJointTrajectory& m, std::int64_t) {
                     std::vector<Vec3> path;
                     for (const auto& point : bus::view(m.points))
                       for (const auto& pose : bus::view(point.transforms)) {
                         path.emplace_back(pose.translation.x, pose.translation.y, pose.translation.z);
                         break;  // of the body, the first joint
                       }
                     const std::lock_guard lock(mutex_);
                     path_.swap(path);
                     fresh_path_ = true;
                   });
  const auto hear = [&](auto& into, const char* topic, std::string view::Frame::*words) {
    return listen_to(into, *participant, topic, latched,
                     [this, words](const DiagnosticArray& m, std::int64_t) {
                       const std::lock_guard lock(mutex_);
                       frame_.*words = words_of(m);
                       fresh_ = true;
                     });
  };
  if (ok) ok = hear(failsafe_, topics::failsafe, &view::Frame::failsafe);
  if (ok) ok = hear(gate_, topics::gate, &view::Frame::gate);
  return ok;
}

std::optional<view::Frame> LiveFlight::news() {
  const std::lock_guard lock(mutex_);
  if (!fresh_) return std::nullopt;
  fresh_ = false;
  return frame_;
}

std::optional<std::vector<Vec3>> LiveFlight::new_path() {
  const std::lock_guard lock(mutex_);
  if (!fresh_path_) return std::nullopt;
  fresh_path_ = false;
  return path_;
}

}  // namespace omniflight::cli
