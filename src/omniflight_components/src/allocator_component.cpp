// The allocator on the bus: answers every demand of the controller with rotor speeds and tilt.
#include <mutex>

#include "control_parameters.hpp"
#include "conversions.hpp"
#include "factories.hpp"
#include "failsafe_message.hpp"
#include "foreign_publisher.hpp"
#include "joint_publisher.hpp"
#include "lost_rotors_message.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/say.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/tilt_schedule_file.hpp"
#include "omniflight_components/topics.hpp"
#include "rotor_losses.hpp"

namespace omniflight::components {
namespace {

using msgs::actuator_msgs::Actuators;
using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::omniflight_msgs::AllocatorState;
using msgs::omniflight_msgs::ControllerState;
using msgs::omniflight_msgs::RotorTelemetry;

class AllocatorComponent final : public bus::Component {
 public:
  AllocatorComponent() : Component("allocator") {}

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "allocator");
    auto read = read_allocator_parameters(p);
    if (!read) return Failure(read.error());
    follow_plan_ = read->follow_plan;
    schedule_ = std::move(read->schedule);
    const vehicle::Vehicle& vehicle = read->vehicle;
    auto allocator = allocation::Allocator::create(vehicle, read->config);
    if (!allocator) return Failure(allocator.error());
    allocator_.emplace(std::move(*allocator));
    if (read->drop_lost) losses_.emplace(vehicle);

    auto state = advertise<AllocatorState>(topics::allocator, bus::Qos::bulk(512));
    if (!state) return Failure(state.error());
    state_.emplace(std::move(*state));
    auto command = advertise<Actuators>(topics::command, bus::Qos::bulk(512));
    if (!command) return Failure(command.error());
    command_.emplace(std::move(*command));
    const auto rotors = static_cast<std::size_t>(vehicle.rotor_count());
    bus::resize(command_message_->velocity, rotors);
    bus::resize(command_message_->position, 1);
    bus::resize(state_message_->thrust, rotors);
    if (losses_)
      if (auto ok = watch_rotors(); !ok) return ok;
    if (read->joints_hz > 0.0)
      if (auto ok = show_joints(vehicle, read->joints_hz); !ok) return ok;
    // Last: from here on threads of the bus answer, with everything above.
    auto demand = bus::Subscription<ControllerState>::create(
        participant(), topics::controller, bus::Qos::bulk(64).from_one_publisher(),
        [this](const ControllerState& m, std::int64_t) { answer(m); }, &say_foreign);
    if (!demand) return Failure(demand.error());
    demand_.emplace(std::move(*demand));
    return {};
  }

  Status watch_rotors() {
    auto lost = advertise<DiagnosticArray>(topics::lost_rotors, bus::Qos::latched_last());
    if (!lost) return Failure(lost.error());
    lost_.emplace(std::move(*lost));
    auto rotors_turn = bus::Subscription<RotorTelemetry>::create(
        participant(), topics::rotors, bus::Qos::bulk(64).from_one_publisher(),
        [this](const RotorTelemetry& m, std::int64_t) {
          losses_->measured(to_s(m.header.stamp), bus::view(m.velocity));
        },
        &say_foreign);
    if (!rotors_turn) return Failure(rotors_turn.error());
    telemetry_.emplace(std::move(*rotors_turn));
    auto ladder = bus::Subscription<DiagnosticArray>::create(
        participant(), topics::failsafe, bus::Qos::latched_last(), [this](const auto& m, std::int64_t) {
          if (const auto action = failsafe_action(m); action && *action >= safety::Action::ramp_down)
            losses_->wind_down();
        });
    if (!ladder) return Failure(ladder.error());
    ladder_.emplace(std::move(*ladder));
    auto gate = bus::Subscription<DiagnosticArray>::create(
        participant(), topics::gate, bus::Qos::latched_last(4), [this](const auto& m, std::int64_t) {
          if (const auto statuses = bus::view(m.status); !statuses.empty())
            losses_->gate(to_s(m.header.stamp), statuses[0].level == 0);  // 0: armed, commands are fresh
        });
    if (!gate) return Failure(gate.error());
    gate_.emplace(std::move(*gate));
    return {};
  }

  Status show_joints(const vehicle::Vehicle& vehicle, double rate_hz) {
    auto states = advertise<msgs::sensor_msgs::JointState>(topics::joints, bus::Qos::bulk(100));
    if (!states) return Failure(states.error());
    auto description = advertise<msgs::std_msgs::String>(topics::robot_description, bus::Qos::latched_last());
    if (!description) return Failure(description.error());
    joints_.emplace(vehicle, rate_hz);
    return joints_->attach(std::move(*states), std::move(*description));
  }

  Status on_cleanup() override {
    joints_.reset();
    telemetry_.reset();
    ladder_.reset();
    gate_.reset();
    demand_.reset();
    lost_.reset();
    state_.reset();
    command_.reset();
    return {};
  }

  void answer(const ControllerState& m) {
    if (m.tick == state_message_->tick && m.tick > 0) return send();  // asked again: it was not heard
    allocation::AllocationInput input;
    input.qdd_ref = get(m.desired_acceleration);
    input.q_WB = get(m.est_attitude);
    input.w_WB_B = get(m.est_angular_velocity);
    input.position_error = (get(m.ref_position) - get(m.est_position)).norm();
    if (const auto alpha = bus::view(m.ref_alpha); follow_plan_ && !alpha.empty())
      input.alpha = alpha.front();
    if (schedule_) input.alpha = schedule_->at(m.trajectory_time);
    const double now_s = to_s(m.header.stamp);
    if (losses_)
      if (const std::string words =
              losses_->update(now_s, m.trajectory_time, get(m.ref_attitude), *allocator_);
          !words.empty())
        tell(m.header.stamp, words);
    const auto result = allocator_->allocate(input);
    if (!result) return finish(Failure(result.error()));
    auto& s = *state_message_;
    s.header.stamp = m.header.stamp;
    s.tick = m.tick;
    s.alpha = result->alpha;
    bus::assign(s.thrust, {result->u.data(), static_cast<std::size_t>(result->u.size())});
    put(s.achieved_acceleration, result->qdd);
    put(s.unachieved_wrench, result->unachieved_wrench);
    s.kkt_residual = result->kkt_residual;
    s.active_bounds = static_cast<std::uint32_t>(result->active_bounds);
    s.w1 = result->w_input;
    if (losses_) {
      losses_->commanded({result->speed.data(), static_cast<std::size_t>(result->speed.size())},
                         result->alpha);
    }
    auto& c = *command_message_;
    c.header.stamp = m.header.stamp;
    bus::assign(c.velocity, {result->speed.data(), static_cast<std::size_t>(result->speed.size())});
    const double alpha[1] = {result->alpha};
    bus::assign(c.position, alpha);
    send();
    if (joints_)
      if (auto ok = joints_->publish(c.header.stamp, bus::view(c.velocity), result->alpha); !ok) finish(ok);
  }

  /// Which rotors are left out from this period on.
  void tell(const bus::Time& stamp, const std::string& words) {
    bus::say("allocator", words);
    fill_lost_rotors(*lost_message_, stamp, losses_->lost(), losses_->hover_load(), words);
    if (auto ok = lost_->publish(*lost_message_, bus::nanoseconds(stamp)); !ok) finish(ok);
  }

  /// The state goes first: publishing the command lets the plant go on in lockstep, and the controller asks
  /// for the state of the tick before.
  void send() {
    const std::int64_t ns = bus::nanoseconds(state_message_->header.stamp);
    if (auto ok = state_->publish(*state_message_, ns); !ok) return finish(ok);
    if (auto ok = command_->publish(*command_message_, ns); !ok) finish(ok);
  }

  std::optional<allocation::Allocator> allocator_;
  std::optional<allocation::TiltSchedule> schedule_;
  std::optional<RotorLosses> losses_;
  std::optional<JointPublisher> joints_;
  bool follow_plan_ = true;
  bus::Message<AllocatorState> state_message_;
  bus::Message<Actuators> command_message_;
  std::optional<bus::Publisher<AllocatorState>> state_;
  std::optional<bus::Publisher<Actuators>> command_;
  std::optional<bus::Subscription<ControllerState>> demand_;
  std::optional<bus::Subscription<RotorTelemetry>> telemetry_;
  std::optional<bus::Subscription<DiagnosticArray>> ladder_, gate_;
  bus::Message<DiagnosticArray> lost_message_;
  std::optional<bus::Publisher<DiagnosticArray>> lost_;
};

}  // namespace

std::unique_ptr<bus::Component> make_allocator() { return std::make_unique<AllocatorComponent>(); }

}  // namespace omniflight::components
