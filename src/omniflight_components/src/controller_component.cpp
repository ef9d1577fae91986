// Estimator and controller on the bus: answers every tick with the acceleration it wants. For anti-windup it
// asks what the allocator achieved of its last demand, so the order is defined: the answer to a tick comes
// after the allocator's state of the tick answered before, whichever process they run in.
#include <atomic>
#include <mutex>

#include "control_parameters.hpp"
#include "conversions.hpp"
#include "estimator_choice.hpp"
#include "factories.hpp"
#include "failsafe_message.hpp"
#include "flight_guard.hpp"
#include "foreign_publisher.hpp"
#include "lost_rotors_message.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/say.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_control/law.hpp"
#include "plant_publisher.hpp"
#include "trajectory_message.hpp"
#include "transform_publisher.hpp"

namespace omniflight::components {
namespace {

using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::omniflight_msgs::AllocatorState;
using msgs::omniflight_msgs::ControllerState;
using msgs::omniflight_msgs::Tick;

class ControllerComponent final : public bus::Component {
 public:
  ControllerComponent() : Component("controller") {}

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "controller");
    const LawParameters law = read_law_parameters(p);
    anti_windup_ = law.anti_windup;
    auto estimator = read_estimator(p);
    settle_ = p.number("settle_s", 1.0, 0, 600);
    auto guard = read_guard(p);
    auto below = read_map_below(p);
    transform_.emplace(read_transform_rate(p));
    if (auto ok = p.finish(); !ok) return ok;
    if (!guard) return Failure(guard.error());
    if (!below) return Failure(below.error());
    if (!estimator) return Failure(estimator.error());
    auto made = make_law(law);
    if (!made) return Failure(made.error());
    guard_.emplace(*guard, std::move(*below));
    law_ = std::move(*made);
    estimator_ = std::move(*estimator);

    auto out = advertise<ControllerState>(topics::controller, bus::Qos::bulk(512));
    if (!out) return Failure(out.error());
    publisher_.emplace(std::move(*out));
    auto said = advertise<DiagnosticArray>(topics::failsafe, bus::Qos::latched_last());
    if (!said) return Failure(said.error());
    failsafe_.emplace(std::move(*said));
    if (transform_->wanted()) {
      // as tf2_ros offers it: reliable, volatile, the last 100
      auto tree = advertise<msgs::tf2_msgs::TFMessage>(topics::transforms, bus::Qos::bulk(100));
      if (!tree) return Failure(tree.error());
      transform_->attach(std::move(*tree));
    }
    return subscribe();
  }

  Status subscribe() {
    using namespace msgs;
    // The tick comes last: once it is there, nothing that belongs to it is missed.
    Status ok = follow_trajectories();
    if (ok)
      ok = listen<sensor_msgs::Imu>(
          imu_, topics::imu, bus::Qos::bulk(64).from_one_publisher(), [this](const auto& m) {
            ++imu_count_;
            const double stamp = to_s(m.header.stamp);
            double t = 0;
            if (!guard_->place_imu(stamp, tick_known_ ? newest_tick_s_ : before_any_tick(stamp), t)) return;
            estimator_->add_imu(t, get(m.linear_acceleration), get(m.angular_velocity));
            time_known_ = true;
          });
    if (ok)
      ok = listen<geometry_msgs::PoseStamped>(
          mocap_, topics::mocap, bus::Qos::bulk(64).from_one_publisher(), [this](const auto& m) {
            const double stamp = to_s(m.header.stamp);
            const Vec3 position = get(m.pose.position);
            const Quat attitude = get_quaternion(m.pose.orientation);
            if (guard_->believes(stamp, position, attitude, flight_time(stamp), free_, *estimator_))
              estimator_->add_mocap(guard_->poses().believed_s(), position, attitude);
            ++mocap_count_;
          });
    if (ok)
      ok = listen<std_msgs::String>(
          wish_subscription_, topics::wish, bus::Qos::latched_last(4),
          [this](const auto& m) { wish_ = heard_after(wish_, wish_from(bus::text(m.data))); });
    if (ok)
      ok = listen<sensor_msgs::BatteryState>(battery_, topics::battery, bus::Qos::bulk(64),
                                             [this](const auto& m) { guard_->battery(m.voltage); });
    if (ok)
      ok = listen<AllocatorState>(allocator_, topics::allocator, bus::Qos::bulk(64), [this](const auto& m) {
        achieved_tick_ = m.tick;
        guard_->tilt(m.alpha);
        achieved_ = get(m.achieved_acceleration);
      });
    if (ok)
      ok = listen<DiagnosticArray>(lost_rotors_, topics::lost_rotors, bus::Qos::latched_last(),
                                   [this](const auto& m) {
                                     if (const auto load = hover_load_in(m))
                                       guard_->rotors(to_s(m.header.stamp), *load);
                                   });
    if (ok)
      ok = listen<Tick>(tick_, topics::tick, bus::Qos::bulk(64).from_one_publisher(), [this](const Tick& m) {
        newest_tick_s_ = to_s(m.header.stamp);
        free_ = m.phase == static_cast<std::uint8_t>(FlightPhase::free);
        time_known_ = tick_known_ = true;
        guard_->tick(newest_tick_s_, m.period);
        repeated_ = pending_ && pending_->index == m.index;
        overtaken_ = pending_ && pending_->index < m.index;
        pending_.emplace(m);
        pending_->header.frame_id = nullptr;
      });
    return ok;
  }

  /// A trajectory that comes in flight takes the place of the one before in the same time. It is built before
  /// the lock is taken: for thousands of knots that takes as long as a control period.
  Status follow_trajectories() {
    using Message = msgs::trajectory_msgs::MultiDOFJointTrajectory;
    auto made = bus::Subscription<Message>::create(
        participant(), topics::trajectory, bus::Qos::latched_last(), [this](const Message& m, std::int64_t) {
          auto received = from_message(m);
          if (!received) return finish(Failure(received.error()));
          {
            const std::lock_guard lock(mutex_);
            tilt_told_ = tells_tilt(m);
            std::swap(trajectory_, *received);
          }
          serve();
        });
    if (!made) return Failure(made.error());
    trajectory_subscription_.emplace(std::move(*made));
    return {};
  }

  /// Takes what arrives under the lock, then lets the component answer outside of it.
  template <class T, class Take>
  Status listen(std::optional<bus::Subscription<T>>& slot, const char* topic, const bus::Qos& qos,
                Take take) {
    auto made = bus::Subscription<T>::create(
        participant(), topic, qos,
        [this, take](const T& m, std::int64_t) {
          {
            const std::lock_guard lock(mutex_);
            take(m);
          }
          serve();
        },
        &say_foreign);
    if (!made) return Failure(made.error());
    slot.emplace(std::move(*made));
    return {};
  }

  Status on_cleanup() override {
    tick_.reset();
    allocator_.reset();
    lost_rotors_.reset();
    mocap_.reset();
    imu_.reset();
    battery_.reset();
    trajectory_subscription_.reset();
    wish_subscription_.reset();
    wish_ = safety::Wish::none;
    failsafe_.reset();
    transform_.reset();
    publisher_.reset();
    return {};
  }

  /// Answers what can be answered. Publishing inside one process calls the others, and through them this
  /// again: whoever is inside already looks once more, so that nothing recurses and the message has one
  /// writer.
  void serve() {
    if (wanted_.fetch_add(1) > 0) return;
    int seen = 0;
    do {
      seen = wanted_.load();
      if (answer()) send();
    } while (!wanted_.compare_exchange_strong(seen, 0));
  }

  /// Makes the answer to the pending tick as soon as everything that belongs to it is here, so that it does
  /// not depend on the order in which topics arrive. True when there is a message to send.
  bool answer() {
    const std::lock_guard lock(mutex_);
    if (!pending_ || imu_count_ < pending_->imu_count || mocap_count_ < pending_->mocap_count) return false;
    if (trajectory_.empty()) return false;  // the plant waits; the planner is latched and will come
    const bool again = std::exchange(repeated_, false);
    if (pending_->index == message_->tick && pending_->index > 0) {  // asked again: it was not heard
      pending_.reset();
      return true;
    }
    const bool known = achieved_tick_ == demanded_tick_;
    if (anti_windup_ && demanded_tick_ > 0 && !known && !overtaken_)
      return again;  // the plant waits, so the last demand or the answer to it was not heard: say it again
    const Tick tick = *pending_;
    pending_.reset();
    overtaken_ = false;
    if (tick.phase == static_cast<std::uint8_t>(FlightPhase::ended)) return false;
    demanded_tick_ = 0;
    const double t = to_s(tick.header.stamp);
    estimated_ = estimator_->ready();
    if (!estimated_) {
      // before the first pose hover thrust along the body z axis is all that can be said
      write(tick, trajectory_.sample(-1.0), -1.0, Vec6::Zero());
      return true;
    }
    const bool held = tick.phase == static_cast<std::uint8_t>(FlightPhase::held);
    if (held) {
      law_->reset();
      free_since_ = t;
    } else if (guard_->update(t, *estimator_, wish_)) {
      say_ = true;
    }
    const double along = held ? -settle_ : t - free_since_ - settle_ - guard_->paused_s();
    const Reference r =
        held ? trajectory_.sample(along) : guard_->reference(trajectory_, along, t, estimator_->state());
    if (guard_->action() == safety::Action::off && !held)
      finish(fail(ErrorCode::incomplete, "the failsafe ended the flight (" + guard_->words() + ")",
                  "controller", "See /omniflight/failsafe in the recording"));
    const Vec6 unachieved = anti_windup_ && known ? Vec6(demand_ - achieved_) : Vec6::Zero();
    demand_ = law_->update(r, estimator_->state(), held ? 0.0 : tick.period, unachieved);
    demanded_tick_ = tick.index;
    write(tick, r, along, demand_);
    return true;
  }

  void write(const Tick& tick, const Reference& r, double along, const Vec6& demand) {
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
    put(m.integral, law_->integral_action());
    put(m.desired_acceleration, demand);
    bus::assign(m.ref_alpha, std::span(&r.alpha, tilt_told_ ? 1 : 0));
  }
  /// Flight time as this component knows it: that of the newest tick or inertial sample.
  double flight_time(double stamp) const {
    return time_known_ ? std::max(newest_tick_s_, estimator_->time()) : before_any_tick(stamp);
  }
  /// The stamp itself, unless no flight lasts that long.
  static double before_any_tick(double stamp) {
    constexpr double kLongestFlight = 36000;  // s
    return stamp >= 0 && stamp <= kLongestFlight ? stamp : 0.0;
  }

  /// What was refused since it was last told, and whose clock is followed; empty: nothing new.
  std::string refusals() {
    std::string out;
    const auto add = [&out](const std::string& words) { out += (out.empty() ? "" : "; ") + words; };
    const std::uint64_t poses = guard_->poses().refused(), imu = guard_->refused_imu();
    if (poses > refusals_told_)
      add(std::to_string(poses - refusals_told_) +
          " poses refused, the last: " + guard_->poses().last_words());
    if (imu > imu_refusals_told_)
      add(std::to_string(imu - imu_refusals_told_) +
          " IMU samples refused, the last: " + guard_->imu_clock().refusal_words());
    if (law_->refused() > demands_kept_told_)
      add("the last demand kept " + std::to_string(law_->refused() - demands_kept_told_) +
          " times: reference, estimate or achieved acceleration is no flight's");
    if (guard_->poses().clock().resets() > pose_resets_told_)
      add("poses: " + guard_->poses().clock().reset_words());
    if (guard_->imu_clock().resets() > imu_resets_told_) add("IMU: " + guard_->imu_clock().reset_words());
    refusals_told_ = poses;
    imu_refusals_told_ = imu;
    demands_kept_told_ = law_->refused();
    pose_resets_told_ = guard_->poses().clock().resets();
    imu_resets_told_ = guard_->imu_clock().resets();
    return out;
  }

  /// What changed, before the answer that it changed: the ladder's action, what was refused, whose clock is
  /// followed.
  void tell() {
    std::string words, landing, refused;
    {
      const std::lock_guard lock(mutex_);
      const bool due = newest_tick_s_ >= next_refusal_s_;  // at most one line a second
      if (say_ || due) refused = refusals();
      if (!std::exchange(say_, false) && refused.empty()) return;
      words = guard_->words();
      landing = guard_->landing_words();
      next_refusal_s_ = newest_tick_s_ + 1.0;
      fill_failsafe(*failsafe_message_, message_->header.stamp, guard_->action(), words, landing, refused,
                    guard_->poses().refused());
    }
    for (const std::string& more : {landing, refused})
      if (!more.empty()) words += "; " + more;
    bus::say("controller", "failsafe " + words);
    const std::int64_t ns = bus::nanoseconds(message_->header.stamp);
    if (auto ok = failsafe_->publish(*failsafe_message_, ns); !ok) finish(ok);
  }

  void send() {
    tell();
    if (auto ok = publisher_->publish(*message_, bus::nanoseconds(message_->header.stamp)); !ok) finish(ok);
    if (!estimated_) return;
    const Vec3 p_WB = get(message_->est_position);
    if (auto ok = transform_->publish(message_->header.stamp, p_WB, get(message_->est_attitude)); !ok)
      finish(ok);
  }

  std::mutex mutex_;  ///< guards everything but message_ and transform_, which serve() alone touches
  std::atomic<int> wanted_{0};
  std::unique_ptr<control::Law> law_;
  std::unique_ptr<control::StateEstimator> estimator_;
  Trajectory trajectory_;
  double settle_ = 1.0, free_since_ = 0.0;
  std::optional<FlightGuard> guard_;
  safety::Wish wish_ = safety::Wish::none;
  double newest_tick_s_ = 0.0, next_refusal_s_ = 0.0;
  bool free_ = false, time_known_ = false, tick_known_ = false, say_ = false;
  std::uint64_t refusals_told_ = 0, imu_refusals_told_ = 0, pose_resets_told_ = 0, imu_resets_told_ = 0,
                demands_kept_told_ = 0;
  bool anti_windup_ = true, tilt_told_ = false;
  std::optional<Tick> pending_;
  bool repeated_ = false;                                 ///< the plant asked the pending tick twice
  bool overtaken_ = false;                                ///< the plant did not wait for an answer: real time
  Vec6 demand_ = Vec6::Zero(), achieved_ = Vec6::Zero();  ///< m/s^2 world, rad/s^2 body
  std::uint64_t demanded_tick_ = 0, achieved_tick_ = 0;   ///< which ticks they belong to
  std::uint64_t imu_count_ = 0, mocap_count_ = 0;
  bool estimated_ = false;  ///< message_ has an estimate
  bus::Message<ControllerState> message_;
  std::optional<TransformPublisher> transform_;
  std::optional<bus::Publisher<ControllerState>> publisher_;
  bus::Message<DiagnosticArray> failsafe_message_;
  std::optional<bus::Publisher<DiagnosticArray>> failsafe_;
  std::optional<bus::Subscription<msgs::std_msgs::String>> wish_subscription_;
  std::optional<bus::Subscription<msgs::trajectory_msgs::MultiDOFJointTrajectory>> trajectory_subscription_;
  std::optional<bus::Subscription<msgs::sensor_msgs::Imu>> imu_;
  std::optional<bus::Subscription<msgs::sensor_msgs::BatteryState>> battery_;
  std::optional<bus::Subscription<AllocatorState>> allocator_;
  std::optional<bus::Subscription<DiagnosticArray>> lost_rotors_;
  std::optional<bus::Subscription<msgs::geometry_msgs::PoseStamped>> mocap_;
  std::optional<bus::Subscription<Tick>> tick_;
};

}  // namespace

std::unique_ptr<bus::Component> make_controller() { return std::make_unique<ControllerComponent>(); }

}  // namespace omniflight::components
