// Estimator and controller on the bus: answers every tick with the acceleration it wants.
#include <mutex>

#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_control/controller.hpp"
#include "omniflight_control/estimator.hpp"
#include "plant_publisher.hpp"
#include "trajectory_message.hpp"

namespace omniflight::components {
namespace {

using msgs::omniflight_msgs::ControllerState;
using msgs::omniflight_msgs::Tick;

class ControllerComponent final : public bus::Component {
 public:
  ControllerComponent() : Component("controller") {}

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "controller");
    control::ControllerConfig c;
    const auto gain = [&](const char* key, const Vec3& otherwise) {
      const auto v = p.numbers(key, std::vector<double>{otherwise.x(), otherwise.y(), otherwise.z()}, 3);
      return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : otherwise;
    };
    c.kp = gain("kp", c.kp);
    c.kv = gain("kv", c.kv);
    c.ki = gain("ki", c.ki);
    c.kR = gain("kR", c.kR);
    c.kw = gain("kw", c.kw);
    c.kI = gain("kI", c.kI);
    c.max_acceleration = p.number("max_acceleration_mps2", c.max_acceleration, 0, 1000);
    c.max_angular_acceleration =
        p.number("max_angular_acceleration_radps2", c.max_angular_acceleration, 0, 10000);
    c.max_integral_acceleration =
        p.number("max_integral_acceleration_mps2", c.max_integral_acceleration, 0, 1000);
    c.max_integral_angular_acceleration =
        p.number("max_integral_angular_acceleration_radps2", c.max_integral_angular_acceleration, 0, 10000);
    c.feed_forward = p.flag("feed_forward", c.feed_forward);
    control::EstimatorConfig e;
    e.position_bandwidth = p.number("estimator_position_bandwidth_radps", e.position_bandwidth, 0.1, 500);
    e.attitude_bandwidth = p.number("estimator_attitude_bandwidth_radps", e.attitude_bandwidth, 0.1, 500);
    e.gyro_bias_gain = p.number("estimator_gyro_bias_gain", e.gyro_bias_gain, 0, 1000);
    settle_ = p.number("settle_s", 1.0, 0, 600);
    mocap_timeout_ = p.number("mocap_timeout_s", 0.5, 0.01, 10);
    if (auto ok = p.finish(); !ok) return ok;
    controller_.emplace(c);
    estimator_.emplace(e);

    auto out = advertise<ControllerState>(topics::controller, bus::Qos::bulk(512));
    if (!out) return Failure(out.error());
    publisher_.emplace(std::move(*out));
    using namespace msgs;
    auto trajectory = bus::Subscription<trajectory_msgs::MultiDOFJointTrajectory>::create(
        participant(), topics::trajectory, bus::Qos::latched_last(),
        [this](const trajectory_msgs::MultiDOFJointTrajectory& m, std::int64_t) {
          auto received = from_message(m);
          if (!received) return finish(Failure(received.error()));
          const std::lock_guard lock(mutex_);
          trajectory_ = std::move(*received);
          answer();
        });
    if (!trajectory) return Failure(trajectory.error());
    trajectory_subscription_.emplace(std::move(*trajectory));
    auto imu = bus::Subscription<sensor_msgs::Imu>::create(
        participant(), topics::imu, bus::Qos::bulk(64), [this](const sensor_msgs::Imu& m, std::int64_t) {
          const std::lock_guard lock(mutex_);
          estimator_->add_imu(to_s(m.header.stamp), get(m.linear_acceleration), get(m.angular_velocity));
          ++imu_count_;
          answer();
        });
    if (!imu) return Failure(imu.error());
    imu_.emplace(std::move(*imu));
    auto mocap = bus::Subscription<geometry_msgs::PoseStamped>::create(
        participant(), topics::mocap, bus::Qos::bulk(64),
        [this](const geometry_msgs::PoseStamped& m, std::int64_t) {
          const std::lock_guard lock(mutex_);
          estimator_->add_mocap(to_s(m.header.stamp), get(m.pose.position),
                                get_quaternion(m.pose.orientation));
          ++mocap_count_;
          answer();
        });
    if (!mocap) return Failure(mocap.error());
    mocap_.emplace(std::move(*mocap));
    auto tick = bus::Subscription<Tick>::create(participant(), topics::tick, bus::Qos::bulk(64),
                                                [this](const Tick& m, std::int64_t) {
                                                  const std::lock_guard lock(mutex_);
                                                  pending_.emplace(m);
                                                  pending_->header.frame_id = nullptr;
                                                  answer();
                                                });
    if (!tick) return Failure(tick.error());
    tick_.emplace(std::move(*tick));
    return {};
  }

  Status on_cleanup() override {
    tick_.reset();
    mocap_.reset();
    imu_.reset();
    trajectory_subscription_.reset();
    publisher_.reset();
    return {};
  }

  /// Called with the lock held: answers the pending tick as soon as everything that belongs to it is here, so
  /// that the answer does not depend on the order in which topics arrive.
  void answer() {
    if (!pending_ || imu_count_ < pending_->imu_count || mocap_count_ < pending_->mocap_count) return;
    if (trajectory_.empty()) return;  // the plant waits; the planner is latched and will come
    const Tick tick = *pending_;
    pending_.reset();
    if (tick.index == message_->tick && tick.index > 0)
      return send();  // asked again: the answer was not heard
    if (tick.phase == static_cast<std::uint8_t>(FlightPhase::ended)) return;
    if (!estimator_->ready()) return publish_nothing_yet(tick);
    const double t = to_s(tick.header.stamp);
    if (t - estimator_->last_mocap() > mocap_timeout_) {
      return finish(fail(ErrorCode::incomplete,
                         "no motion capture for " + std::to_string(t - estimator_->last_mocap()) + " s",
                         "controller", "See whether the markers are visible"));
    }
    const bool held = tick.phase == static_cast<std::uint8_t>(FlightPhase::held);
    if (held) {
      controller_->reset();
      free_since_ = t;
    }
    const double along = held ? -settle_ : t - free_since_ - settle_;
    const Reference r = trajectory_.sample(along);
    const Vec6 demand = controller_->update(r, estimator_->state(), held ? 0.0 : tick.period);
    publish(tick, r, along, demand);
  }

  /// Before the first pose: hover thrust along the body z axis is all that can be said.
  void publish_nothing_yet(const Tick& tick) { publish(tick, trajectory_.sample(-1.0), -1.0, Vec6::Zero()); }

  void publish(const Tick& tick, const Reference& r, double along, const Vec6& demand) {
    auto& m = *message_;
    const RigidState& s = estimator_->state();
    m.header.stamp = tick.header.stamp;
    m.tick = tick.index;
    m.following = along >= 0.0 && along <= trajectory_.duration();
    m.trajectory_time = along;
    put(m.ref_position, r.p_WB);
    put(m.ref_attitude, r.q_WB);
    put(m.ref_velocity, r.v_WB_W);
    put(m.ref_angular_velocity, r.w_WB_B);
    put(m.ref_acceleration, r.a_WB_W);
    put(m.ref_angular_acceleration, r.dw_WB_B);
    put(m.est_position, s.p_WB);
    put(m.est_attitude, s.q_WB);
    put(m.est_velocity, s.v_WB_W);
    put(m.est_angular_velocity, s.w_WB_B);
    put(m.integral, controller_->integral_action());
    put(m.desired_acceleration, demand);
    send();
  }
  void send() {
    if (auto ok = publisher_->publish(*message_, bus::nanoseconds(message_->header.stamp)); !ok) finish(ok);
  }

  std::mutex mutex_;
  std::optional<control::Controller> controller_;
  std::optional<control::Estimator> estimator_;
  Trajectory trajectory_;
  double settle_ = 1.0, free_since_ = 0.0, mocap_timeout_ = 0.5;
  std::optional<Tick> pending_;
  std::uint64_t imu_count_ = 0, mocap_count_ = 0;
  bus::Message<ControllerState> message_;
  std::optional<bus::Publisher<ControllerState>> publisher_;
  std::optional<bus::Subscription<msgs::trajectory_msgs::MultiDOFJointTrajectory>> trajectory_subscription_;
  std::optional<bus::Subscription<msgs::sensor_msgs::Imu>> imu_;
  std::optional<bus::Subscription<msgs::geometry_msgs::PoseStamped>> mocap_;
  std::optional<bus::Subscription<Tick>> tick_;
};

}  // namespace

std::unique_ptr<bus::Component> make_controller() { return std::make_unique<ControllerComponent>(); }

}  // namespace omniflight::components
