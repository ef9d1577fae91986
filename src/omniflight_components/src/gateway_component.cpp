// The hardware on the bus: boards behind a safety gate. Clock master of a tethered flight, in real time.
#include <atomic>
#include <filesystem>

#include "command_inbox.hpp"
#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_gateway/gateway.hpp"
#include "omniflight_gateway/safety_gate.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "plant_publisher.hpp"
#include "threaded_component.hpp"
#include "wall_pace.hpp"

namespace omniflight::components {
namespace {

class GatewayComponent final : public ThreadedComponent {
 public:
  GatewayComponent() : ThreadedComponent("gateway") {}
  ~GatewayComponent() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "gateway");
    const std::string vehicle_name = p.text("vehicle", {});
    const std::string overrides = p.text("vehicle_set", "");
    const std::string devices = p.text("devices", {});
    epoch_ns_ = p.integer("epoch_ns", 0, 0);
    period_ = p.number("control_period_s", 0.002, 0.001, 0.1);
    hold_ = p.number("hold_s", 2.0, 0.1, 60);
    flight_ = p.number("flight_s", 10.0, 0.1, 36000);
    alpha_ = to_radians(p.number("alpha_deg", 30.0, -180, 180));
    connect_timeout_ = p.number("connect_timeout_s", 20.0, 1, 120);
    gateway::GateConfig gate;
    gate.stale_after_s = p.number("stale_after_s", 0.1, 0.005, 2.0);
    const double silence = p.number("board_silence_s", gateway::LinkConfig{}.silence_s, 0.02, 10);
    gate.ramp_s = p.number("ramp_s", 0.5, 0.01, 10);
    gate.max_acceleration_radps2 = p.number("max_rotor_acceleration_radps2", 1e5, 1, 1e8);
    if (auto ok = p.finish(); !ok) return ok;
    auto vehicle = vehicle::load_vehicle(vehicle_name, split(overrides));
    if (!vehicle) return Failure(vehicle.error());
    rotors_ = static_cast<std::size_t>(vehicle->rotor_count());
    gate.rotors = rotors_;
    for (const auto& r : vehicle->rotors)
      gate.max_speed_radps = std::max(gate.max_speed_radps, 1.001 * r.max_speed());
    auto made_gate = gateway::SafetyGate::create(gate);
    if (!made_gate) return Failure(made_gate.error());
    gate_.emplace(std::move(*made_gate));
    gateway::GatewayConfig config;
    config.rotors = rotors_;
    config.motor_rate_hz = 250;
    config.link.silence_s = silence;
    for (const std::string& device : split(devices)) config.boards.push_back({.device = device});
    auto made = gateway::Gateway::create(std::move(config));
    if (!made) return Failure(made.error());
    gateway_.emplace(std::move(*made));
    if (auto ok = create_publishers(publisher_, static_cast<int>(rotors_), PlantPublisher::Part::boards); !ok)
      return ok;
    return inbox_.subscribe(participant());
  }
  Status on_cleanup() override {
    stop();
    inbox_.unsubscribe();
    publisher_.destroy();
    return {};
  }

  /// Polls until the gateway reaches a phase.
  Status reach(const WallPace& pace, gateway::GatewayPhase phase, double timeout) {
    const double deadline = pace.now() + timeout;
    while (gateway_->phase() != phase) {
      if (!running()) return fail(ErrorCode::incomplete, "stopped before the flight began", "gateway");
      if (auto ok = gateway_->poll(pace.now(), 0.0); !ok) return ok;
      if (pace.now() > deadline)
        return fail(ErrorCode::incomplete,
                    "the boards did not reach '" + std::string(gateway::to_string(phase)) + "' within " +
                        std::to_string(timeout) + " s",
                    "gateway", "See whether all boards are powered and plugged in");
      pace.sleep_until(pace.now() + 0.002);
    }
    return {};
  }

  void publish_telemetry() {
    gateway_->fetch(telemetry_);
    for (const auto& s : telemetry_.imu) (void)publisher_.imu({s.time_s, s.specific_force_B, s.w_WB_B});
    for (const auto& s : telemetry_.rotors) {
      if (s.rotor >= rotors_) continue;
      speed_[s.rotor] = s.speed_radps;
      current_[s.rotor] = s.current_A;
      // one message a round of all rotors, stamped with the last one
      if (s.rotor + 1 == rotors_)
        (void)publisher_.rotors(s.time_s, {speed_.data(), rotors_}, {current_.data(), rotors_}, alpha_);
    }
    for (const auto& s : telemetry_.battery) (void)publisher_.battery({s.arrival_s, s.voltage_V, 0.0});
    telemetry_.clear();
  }

  Status run() override {
    const WallPace pace(epoch_ns_);
    const auto status = fly(pace);
    (void)gateway_->stop_motors();
    (void)gateway_->poll(pace.now(), 0.0);
    std::uint64_t refused = gate_->refused();
    if (!status) return status;
    if (refused > 0)
      std::fprintf(stderr, "gateway: %lu commands refused\n", static_cast<unsigned long>(refused));
    return {};
  }

  Status fly(const WallPace& pace) {
    const double deadline = pace.now() + connect_timeout_;
    Status connected = gateway_->connect(pace.now());
    while (!connected && pace.now() < deadline && running()) {  // the boards may not be there yet
      pace.sleep_until(pace.now() + 0.1);
      connected = gateway_->connect(pace.now());
    }
    if (!connected) return connected;
    if (auto ok = reach(pace, gateway::GatewayPhase::connected, connect_timeout_); !ok) return ok;
    // nobody starts motors before someone commands them
    while (inbox_.subscription().peers() == 0 || publisher_.tick_publisher().peers() == 0) {
      if (!running()) return fail(ErrorCode::incomplete, "stopped before the flight began", "gateway");
      if (pace.now() > deadline)
        return fail(ErrorCode::incomplete, "no controller and allocator within the connect timeout",
                    "gateway", "Start them in the same domain");
      if (auto ok = gateway_->poll(pace.now(), 0.0); !ok) return ok;
      pace.sleep_until(pace.now() + 0.01);
    }
    if (auto ok = gateway_->start_motors(pace.now()); !ok) return ok;
    if (auto ok = reach(pace, gateway::GatewayPhase::running, 10.0); !ok) return ok;
    publish_telemetry();

    // wait, rotors idle, until the controller answers; then arm
    double next = pace.now();
    std::optional<double> armed_at, free_at;
    std::int64_t last_stamp = -1;
    for (;; next += period_) {
      pace.sleep_until(next);
      const double now = pace.now();
      if (now > next + 5 * period_) next = now;  // periods that the machine slept through are left out
      if (!running()) return fail(ErrorCode::incomplete, "stopped in flight", "gateway");
      if (auto ok = gateway_->poll(now, 0.0); !ok) {
        gate_->trip(gateway::Trip::link_lost, now);
        end_flight(now);
        return ok;
      }
      publish_telemetry();
      const bool ended = free_at && now > *free_at + flight_;
      const FlightPhase phase =
          ended ? FlightPhase::ended : (free_at ? FlightPhase::free : FlightPhase::held);
      if (auto ok = publisher_.tick(now, period_, phase); !ok) return ok;
      if (ended) return wind_down(pace);
      const RotorCommand command = inbox_.newest();
      if (command.stamp_ns > last_stamp && command.count > 0) {
        last_stamp = command.stamp_ns;
        if (!armed_at) {
          if (auto ok = gate_->arm(now); !ok) return ok;
          armed_at = now;
        }
        (void)gate_->offer({command.speed.data(), command.count}, to_s(command.stamp_ns), now);
      }
      if (!armed_at && now > deadline + connect_timeout_)
        return fail(ErrorCode::incomplete, "the allocator commands nothing", "gateway",
                    "See whether it is alive");
      if (armed_at && !free_at && now - *armed_at > hold_) free_at = now;
      const auto out = gate_->update(now);
      if (gateway_->emergency()) gate_->trip(gateway::Trip::board_emergency, now);
      if (armed_at && out.state != gateway::GateState::armed) {
        end_flight(now);
        auto wound = wind_down(pace);
        return fail(
            ErrorCode::incomplete,
            "the safety gate stopped the rotors: " + std::string(gateway::to_string(gate_->trip_reason())),
            "gateway", "See whether controller and allocator are still alive");
      }
      if (armed_at && !out.stop_motors)
        if (auto ok = gateway_->send_velocities(out.speeds_radps); !ok) return ok;
    }
  }

  void end_flight(double now) { (void)publisher_.tick(now, period_, FlightPhase::ended); }

  /// Ramps the rotors down through the gate, bounded in time.
  Status wind_down(const WallPace& pace) {
    gate_->trip(gateway::Trip::requested, pace.now());
    const double deadline = pace.now() + gate_->config().ramp_s + 1.0;
    while (pace.now() < deadline) {
      const auto out = gate_->update(pace.now());
      if (out.stop_motors) break;
      (void)gateway_->send_velocities(out.speeds_radps);
      (void)gateway_->poll(pace.now(), 0.0);
      pace.sleep_until(pace.now() + period_);
    }
    return {};
  }

  std::size_t rotors_ = 0;
  std::int64_t epoch_ns_ = 0;
  double period_ = 0.002, hold_ = 2.0, flight_ = 10.0, alpha_ = 0, connect_timeout_ = 20;
  std::optional<gateway::SafetyGate> gate_;
  std::optional<gateway::Gateway> gateway_;
  gateway::Telemetry telemetry_;
  std::array<double, vehicle::kMaxRotors> speed_{}, current_{};
  PlantPublisher publisher_;
  CommandInbox inbox_;
};

}  // namespace

std::unique_ptr<bus::Component> make_gateway() { return std::make_unique<GatewayComponent>(); }

}  // namespace omniflight::components
