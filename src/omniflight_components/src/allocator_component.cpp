// The allocator on the bus: answers every demand of the controller with rotor speeds and tilt.
#include <mutex>

#include "conversions.hpp"
#include "factories.hpp"
#include "foreign_publisher.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"

namespace omniflight::components {
namespace {

using msgs::actuator_msgs::Actuators;
using msgs::omniflight_msgs::AllocatorState;
using msgs::omniflight_msgs::ControllerState;

class AllocatorComponent final : public bus::Component {
 public:
  AllocatorComponent() : Component("allocator") {}

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "allocator");
    const std::string vehicle_name = p.text("vehicle", {});
    const std::string overrides = p.text("vehicle_set", "");
    const std::string weights = p.text("weights", "case_a");
    const std::string mode = p.text("tilt_mode", "fixed");
    const double alpha_deg = p.number("alpha_deg", 30.0, -180, 180);
    follow_plan_ = p.flag("follow_plan", true);  // false: stays at alpha_deg whatever the plan says
    auto config =
        weights == "case_a" ? allocation::AllocatorConfig::case_a() : allocation::AllocatorConfig::case_b();
    if (weights != "case_a" && weights != "case_b" && weights != "dynamic")
      return bad_input("'" + weights + "' is neither case_a nor case_b nor dynamic", "allocator.weights");
    if (mode != "fixed" && mode != "search")
      return bad_input("'" + mode + "' is neither fixed nor search", "allocator.tilt_mode");
    config.w_input = p.number("w_input", config.w_input, 0, 1e6);
    config.w_rate = p.number("w_rate", config.w_rate, 0, 1e6);
    config.w_linear = p.number("w_linear", config.w_linear, 1e-12, 1e12);
    config.w_angular = p.number("w_angular", config.w_angular, 1e-12, 1e12);
    config.tilt_step = to_radians(p.number("tilt_step_deg", to_degrees(config.tilt_step), 0, 10));
    config.tilt_candidates = static_cast<int>(p.number("tilt_candidates", config.tilt_candidates, 1, 8));
    config.mass = p.number("mass_kg", 0.0, 0, 1000);
    config.keep_min_thrust = p.flag("keep_min_thrust", false);
    auto& dynamic = config.dynamic_weights;  // eq. 5.3, on top of case_b under the name `dynamic`
    dynamic.enabled = p.flag("dynamic_weights", weights == "dynamic");
    dynamic.threshold = p.number("dynamic_threshold_m", dynamic.threshold, 1e-6, 10);
    dynamic.growth = p.number("dynamic_growth", dynamic.growth, 1, 10);
    dynamic.shrink = p.number("dynamic_shrink", dynamic.shrink, 1e-3, 1);
    dynamic.floor = p.number("dynamic_floor", dynamic.floor, 1e-15, 1e6);
    dynamic.ceiling = p.number("dynamic_ceiling", dynamic.ceiling, 1e-15, 1e6);
    config.tilt_mode = mode == "search" ? allocation::TiltMode::search : allocation::TiltMode::fixed;
    config.initial_tilt = to_radians(alpha_deg);
    if (auto ok = p.finish(); !ok) return ok;
    auto vehicle = vehicle::load_vehicle(vehicle_name, split(overrides));
    if (!vehicle) return Failure(vehicle.error());
    if (vehicle->tilt.kind == vehicle::TiltKind::none) {
      config.tilt_mode = allocation::TiltMode::fixed;
      config.initial_tilt = 0.0;
    }
    auto allocator = allocation::Allocator::create(*vehicle, config);
    if (!allocator) return Failure(allocator.error());
    allocator_.emplace(std::move(*allocator));

    auto state = advertise<AllocatorState>(topics::allocator, bus::Qos::bulk(512));
    if (!state) return Failure(state.error());
    state_.emplace(std::move(*state));
    auto command = advertise<Actuators>(topics::command, bus::Qos::bulk(512));
    if (!command) return Failure(command.error());
    command_.emplace(std::move(*command));
    const auto rotors = static_cast<std::size_t>(vehicle->rotor_count());
    bus::resize(command_message_->velocity, rotors);
    bus::resize(command_message_->position, 1);
    bus::resize(state_message_->thrust, rotors);
    auto demand = bus::Subscription<ControllerState>::create(
        participant(), topics::controller, bus::Qos::bulk(64).from_one_publisher(),
        [this](const ControllerState& m, std::int64_t) { answer(m); }, &say_foreign);
    if (!demand) return Failure(demand.error());
    demand_.emplace(std::move(*demand));
    return {};
  }

  Status on_cleanup() override {
    demand_.reset();
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
    auto& c = *command_message_;
    c.header.stamp = m.header.stamp;
    bus::assign(c.velocity, {result->speed.data(), static_cast<std::size_t>(result->speed.size())});
    const double alpha[1] = {result->alpha};
    bus::assign(c.position, alpha);
    send();
  }

  /// The state goes first: publishing the command lets the plant go on in lockstep, and the controller asks
  /// for the state of the tick before.
  void send() {
    const std::int64_t ns = bus::nanoseconds(state_message_->header.stamp);
    if (auto ok = state_->publish(*state_message_, ns); !ok) return finish(ok);
    if (auto ok = command_->publish(*command_message_, ns); !ok) finish(ok);
  }

  std::optional<allocation::Allocator> allocator_;
  bool follow_plan_ = true;
  bus::Message<AllocatorState> state_message_;
  bus::Message<Actuators> command_message_;
  std::optional<bus::Publisher<AllocatorState>> state_;
  std::optional<bus::Publisher<Actuators>> command_;
  std::optional<bus::Subscription<ControllerState>> demand_;
};

}  // namespace

std::unique_ptr<bus::Component> make_allocator() { return std::make_unique<AllocatorComponent>(); }

}  // namespace omniflight::components
