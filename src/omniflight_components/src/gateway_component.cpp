// The hardware on the bus: boards behind a safety gate. Clock master of a tethered flight, in real time.
#include <atomic>
#include <filesystem>

#include "command_clock.hpp"
#include "command_inbox.hpp"
#include "conversions.hpp"
#include "factories.hpp"
#include "failsafe_message.hpp"
#include "gate_parameters.hpp"
#include "omniflight_bus/heartbeat.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/say.hpp"
#include "omniflight_gateway/gateway.hpp"
#include "omniflight_gateway/safety_gate.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "page_faults.hpp"
#include "period_keeper.hpp"
#include "period_summary.hpp"
#include "plant_publisher.hpp"
#include "real_time.hpp"
#include "single_status.hpp"
#include "start_permission.hpp"
#include "threaded_component.hpp"
#include "wall_pace.hpp"

namespace omniflight::components {
namespace {

using msgs::diagnostic_msgs::DiagnosticArray;

class GatewayComponent final : public ThreadedComponent {
 public:
  GatewayComponent() : ThreadedComponent("gateway") { widen_thread_heaps(); }
  ~GatewayComponent() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "gateway");
    const std::string vehicle_name = p.text("vehicle", {});
    const std::string overrides = p.text("vehicle_set", "");
    const std::string devices = p.text("devices", {});
    epoch_ns_ = p.integer("epoch_monotonic_ns", 0, 0);
    period_ = p.number("control_period_s", 0.002, 0.001, 0.1);
    hold_ = p.number("hold_s", 2.0, 0.1, 60);
    flight_ = p.number("flight_s", 10.0, 0.1, 36000);
    alpha_ = to_radians(p.number("alpha_deg", 30.0, -180, 180));
    connect_timeout_ = p.number("connect_timeout_s", 20.0, 1, 120);
    auto gate = read_gate(p, period_);
    const double silence = p.number("board_silence_s", gateway::LinkConfig{}.silence_s, 0.02, 10);
    const double stall = p.number("board_stall_s", gateway::LinkConfig{}.write_stall_s, 0.02, 10);
    summary_file_ = p.text("summary_file", "");
    operator_arms_ = p.flag("operator_arms", false);
    arming_timeout_ = p.number("arming_timeout_s", 600, 1, 36000);
    const std::string plan = p.text("plan", "");
    permission_.read(p);
    if (auto ok = p.finish(); !ok) return ok;
    auto vehicle = vehicle::load_vehicle(vehicle_name, split(overrides));
    if (!vehicle) return Failure(vehicle.error());
    if (auto ok = check_plan(plan, *vehicle); !ok) return ok;
    rotors_ = static_cast<std::size_t>(vehicle->rotor_count());
    gate.rotors = rotors_;
    for (const auto& r : vehicle->rotors)
      gate.max_speed_radps = std::max(gate.max_speed_radps, 1.001 * r.max_speed());
    auto made_gate = gateway::SafetyGate::create(gate);
    if (!made_gate) return Failure(made_gate.error());
    gate_.emplace(std::move(*made_gate));
    command_clock_.emplace("gateway", gate.future_tolerance_s, gate.stale_after_s);
    gateway::GatewayConfig config;
    config.rotors = rotors_;
    config.motor_rate_hz = 250;
    config.link.silence_s = silence;
    config.link.write_stall_s = stall;
    for (const std::string& device : split(devices)) config.boards.push_back({.device = device});
    auto made = gateway::Gateway::create(std::move(config));
    if (!made) return Failure(made.error());
    gateway_.emplace(std::move(*made));
    if (auto ok = create_publishers(publisher_, static_cast<int>(rotors_), PlantPublisher::Part::boards); !ok)
      return ok;
    auto failsafe = bus::Subscription<DiagnosticArray>::create(
        participant(), topics::failsafe, bus::Qos::latched_last(4),
        [this](const DiagnosticArray& m, std::int64_t) {
          const auto action = failsafe_action(m);
          if (!action || failsafe_action_.load() >= safety::Action::ramp_down) return;
          if (*action >= safety::Action::ramp_down) {
            const std::lock_guard lock(failsafe_mutex_);
            failsafe_words_ = bus::text(bus::view(m.status)[0].message);
            if (const auto wish = wish_of_ladder(m); wish != safety::Wish::none) hear(wish);
          }
          failsafe_action_.store(*action);  // last: whoever obeys it says why
        });
    if (!failsafe) return Failure(failsafe.error());
    failsafe_.emplace(std::move(*failsafe));
    auto wish = bus::Subscription<msgs::std_msgs::String>::create(
        participant(), topics::wish, bus::Qos::latched_last(4),
        [this](const msgs::std_msgs::String& m, std::int64_t) {
          if (bus::text(m.data) == "arm")
            arm_asked_.store(true);
          else
            hear(wish_from(bus::text(m.data)));
        });
    if (!wish) return Failure(wish.error());
    wish_subscription_.emplace(std::move(*wish));
    if (auto ok = permission_.subscribe(participant()); !ok) return ok;
    auto watch = bus::HeartbeatWatch::start(
        participant(), bus::heartbeat_lease, [this](const std::string& who, bool alive, double silence_s) {
          silences_.note(who, alive, silence_s, WallPace(epoch_ns_).now());
        });
    if (!watch) return Failure(watch.error());
    watch_.emplace(std::move(*watch));
    auto gate_state = advertise<DiagnosticArray>(topics::gate, bus::Qos::latched_last());
    if (!gate_state) return Failure(gate_state.error());
    gate_publisher_.emplace(std::move(*gate_state));
    return inbox_.subscribe(participant());
  }
  Status on_cleanup() override {
    stop();
    watch_.reset();
    failsafe_.reset();
    wish_subscription_.reset();
    wish_.store(safety::Wish::none);
    permission_.unsubscribe();
    gate_publisher_.reset();
    inbox_.unsubscribe();
    publisher_.destroy();
    return {};
  }

  /// From the threads that hear the operator and the ladder.
  void hear(safety::Wish said) {
    auto before = wish_.load();
    while (!wish_.compare_exchange_weak(before, heard_after(before, said))) {
    }
  }

  /// Polls until the gateway reaches a phase.
  Status reach(const WallPace& pace, gateway::GatewayPhase phase, double timeout) {
    const double deadline = pace.now() + timeout;
    while (gateway_->phase() != phase) {
      if (!running()) return fail(ErrorCode::incomplete, "stopped before the flight began", "gateway");
      if (auto ok = not_stopped_yet(pace.now()); !ok) return ok;
      if (auto ok = gateway_->poll(pace.now(), 0.0); !ok) return ok;
      if (pace.now() > deadline)
        return fail(
            ErrorCode::incomplete,
            fmt::format("the boards did not reach '{}' within {} s", gateway::to_string(phase), timeout),
            "gateway", "See whether all boards are powered and plugged in");
      pace.sleep_until(pace.now() + 0.002);
    }
    return {};
  }

  Status check_start() const {
    if (publisher_.tick_publisher().peers() == 0)
      return fail(ErrorCode::incomplete, "no controller follows the ticks", "gateway",
                  "Start it in the same domain");
    return permission_.judge(inbox_.subscription().peers(), battery_);
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
    for (const auto& s : telemetry_.battery) {
      battery_ = s.voltage_V;
      (void)publisher_.battery({s.arrival_s, s.voltage_V, 0.0});
    }
    telemetry_.clear();
  }

  Status run() override {
    ask_for_real_time("gateway");
    const WallPace pace(epoch_ns_);
    const auto status = fly(pace);
    (void)gateway_->stop_motors();
    (void)gateway_->poll(pace.now(), 0.0);
    if (wish_.load() >= safety::Wish::stop) stay_to_answer(pace);
    if (!keeper_) return status;
    const PeriodCounts counts = count_periods();
    std::fprintf(stderr, "[gateway] %s\n", words(counts).c_str());
    const Status written = write_summary(counts, silences_.list(), summary_file_);
    return status ? written : status;
  }

  PeriodCounts count_periods() const {
    return {keeper_->periods(), keeper_->missed(), keeper_->longest_late_s(), gate_->refused(),
            page_faults_.count()};
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
    if (auto ok = wait_for_start(pace, deadline); !ok) return ok;
    if (auto ok = gateway_->start_motors(pace.now()); !ok) return ok;
    if (auto ok = reach(pace, gateway::GatewayPhase::running, 10.0); !ok) return ok;
    publish_telemetry();

    const Status flown = follow_commands(pace, deadline + connect_timeout_);
    page_faults_.end();
    (void)publisher_.tick(pace.now(), period_, FlightPhase::ended);
    wind_down(pace);  // whatever ended the flight
    return flown;
  }

  /// Until the gate is armed rotors stand or idle: a stop needs no ramp, and nobody's command.
  Status not_stopped_yet(double now) {
    if (wish_.load() < safety::Wish::stop) return {};
    gate_->cut(gateway::Trip::emergency_stop);
    tell_gate(now);
    return fail(ErrorCode::incomplete, "the operator stopped it before the flight began", "gateway");
  }

  /// No motor starts before everything is there that a flight needs and, where he has to, the operator has
  /// armed. His word counts only when nothing is missing at that moment.
  Status wait_for_start(const WallPace& pace, double deadline) {
    constexpr double kLook = 0.01;  // s
    for (;;) {
      permission_.look(pace.now(), kLook);
      if (auto ok = not_stopped_yet(pace.now()); !ok) return ok;
      const Status ready = check_start();
      const bool asked = arm_asked_.exchange(false);
      if (ready && (asked || !operator_arms_)) return {};
      if (!running()) return fail(ErrorCode::incomplete, "stopped before the flight began", "gateway");
      if (ready && pace.now() > deadline + arming_timeout_)
        return fail(ErrorCode::incomplete,
                    fmt::format("the operator has not armed within {} s", arming_timeout_), "gateway",
                    "Press a in the terminal of fly, or run omniflight arm");
      if (!ready && pace.now() > deadline) return ready;
      tell(ready ? "disarmed: ready, the operator may arm"
                 : (asked ? "disarmed: NOT armed: " : "disarmed: ") + ready.error().message,
           pace.now());
      if (auto ok = gateway_->poll(pace.now(), 0.0); !ok) return ok;
      publish_telemetry();
      pace.sleep_until(pace.now() + kLook);
    }
  }

  static constexpr double kLongestDescent = 50.0;  ///< s, beyond the planned end

  /// From idle rotors to the end of the flight, at each control period: telemetry, tick, command. The caller
  /// winds the rotors down.
  Status follow_commands(const WallPace& pace, double first_command_by) {
    keeper_.emplace(pace, period_);
    std::optional<double> armed_at, free_at;
    std::uint64_t taken = 0;
    for (;;) {
      const double now = keeper_->wait();
      if (!running()) return fail(ErrorCode::incomplete, "stopped in flight", "gateway");
      if (auto ok = gateway_->poll(now, 0.0); !ok) {
        gate_->trip(gateway::Trip::link_lost, now);
        return ok;
      }
      publish_telemetry();
      if (free_at && now > *free_at + flight_ + (descends() ? kLongestDescent : 0.0)) return {};
      const FlightPhase phase = free_at ? FlightPhase::free : FlightPhase::held;
      if (auto ok = publisher_.tick(now, period_, phase); !ok) return ok;
      const RotorCommand command = inbox_.newest();
      if (command.number != taken && command.count > 0) {
        taken = command.number;
        bool believed = false;
        const double taken_s = command_clock_->place(command.stamp_ns, now, believed);
        if (!armed_at && believed) {
          if (auto ok = gate_->arm(now); !ok) return ok;
          armed_at = now;
          page_faults_.begin();
        }
        if (armed_at) (void)gate_->offer({command.speed.data(), command.count}, taken_s, now);
      }
      if (!armed_at)
        if (auto ok = not_stopped_yet(now); !ok) return ok;
      if (!armed_at && now > first_command_by)
        return fail(ErrorCode::incomplete, "the allocator commands nothing", "gateway",
                    "See whether it is alive");
      if (armed_at && !free_at && now - *armed_at > hold_) free_at = now;
      const auto out = gate_->update(now);
      if (gateway_->emergency()) gate_->trip(gateway::Trip::board_emergency, now);
      obey_failsafe(now);
      tell_gate(now);
      if (armed_at && !gate_->passes()) return stopped_by_gate();
      if (armed_at && !out.stop_motors)
        if (auto ok = gateway_->send_velocities(out.speeds_radps); !ok) return ok;
    }
  }

  /// Publishes the state of the gate when it has changed: an emergency stop is acknowledged by it. Also when
  /// periods were missed, at most once a second.
  void tell_gate(double now) {
    const bool missed = keeper_ && keeper_->missed() != missed_told_ && now >= next_missed_s_;
    const bool changed = told_ != gate_->state();
    if (!changed && !missed) return;
    told_ = gate_->state();
    if (keeper_) missed_told_ = keeper_->missed();
    next_missed_s_ = now + 1.0;
    std::string words(gateway::to_string(gate_->state()));
    if (gate_->trip_reason() != gateway::Trip::none)
      words += fmt::format(": {}", gateway::to_string(gate_->trip_reason()));
    if (changed) bus::say("gateway", fmt::format("gate {} at {:.4f} s", words, now));
    tell(words, now);
  }

  /// On /omniflight/gate, when it is not what was told before, or counts have changed.
  void tell(const std::string& words, double now) {
    if (words == told_words_ && !keeper_) return;
    told_words_ = words;
    auto& m = *gate_message_;
    const int level = gate_->state() == gateway::GateState::armed ? 0 : 1;
    auto& status = fill_single_status(m, bus::stamp(to_ns(now)), level, "omniflight: gate", words);
    if (keeper_) fill(status.values, count_periods());
    // who listens does so to know; the rotors do not wait for it
    (void)gate_publisher_->publish(m, to_ns(now));
  }

  /// Then the failsafe ends the flight, on the ground, and not the plan's end above it.
  bool descends() const { return failsafe_action_.load() >= safety::Action::descend; }

  /// The worst that the controller's ladder and the operator ask for.
  void obey_failsafe(double now) {
    const auto action = failsafe_action_.load();
    const auto wish = wish_.load();
    if (wish == safety::Wish::cut || action == safety::Action::off)
      gate_->cut(wish == safety::Wish::cut ? gateway::Trip::emergency_stop : gateway::Trip::failsafe);
    else if (wish == safety::Wish::stop || action == safety::Action::ramp_down)
      gate_->trip(wish == safety::Wish::stop ? gateway::Trip::requested : gateway::Trip::failsafe, now);
  }

  Status stopped_by_gate() {
    std::string why(gateway::to_string(gate_->trip_reason()));
    if (gate_->trip_reason() == gateway::Trip::failsafe) {
      const std::lock_guard lock(failsafe_mutex_);
      why += " (" + failsafe_words_ + ")";
    }
    return fail(ErrorCode::incomplete, "the safety gate stopped the rotors: " + why, "gateway",
                gate_->trip_reason() == gateway::Trip::stale_command
                    ? "See whether controller and allocator are still alive"
                    : "See /omniflight/failsafe in the recording");
  }

  /// Winds the rotors down through the gate, bounded in time. Also when a board is lost: the others get it.
  /// An emergency stop ends the ramp.
  void wind_down(const WallPace& pace) {
    gate_->trip(gateway::Trip::requested, pace.now());
    const double deadline = pace.now() + gate_->config().ramp_s + 1.0;
    while (pace.now() < deadline) {
      if (wish_.load() == safety::Wish::cut) gate_->cut(gateway::Trip::emergency_stop);
      const auto out = gate_->update(pace.now());
      tell_gate(pace.now());
      if (out.stop_motors) break;
      (void)gateway_->send_velocities(out.speeds_radps);
      (void)gateway_->poll(pace.now(), 0.0);
      gateway_->fetch(telemetry_);  // nobody listens any more, but the buffers stay bounded
      pace.sleep_until(pace.now() + period_);
    }
  }

  /// Keeps the last state of the gate readable for an operator whose stop was obeyed before his program had
  /// found the gate: the motors, which are stopped by now, do not wait for discovery; the acknowledgement has
  /// to.
  void stay_to_answer(const WallPace& pace) {
    constexpr double kDiscovery = 1.5;  // s, beyond what two participants of a loaded machine need
    const double end = pace.now() + kDiscovery;
    while (pace.now() < end && running()) {
      (void)gateway_->poll(pace.now(), 0.0);
      gateway_->fetch(telemetry_);
      pace.sleep_until(pace.now() + period_);
    }
  }

  std::size_t rotors_ = 0;
  std::int64_t epoch_ns_ = 0;
  double period_ = 0.002, hold_ = 2.0, flight_ = 10.0, alpha_ = 0, connect_timeout_ = 20;
  std::optional<gateway::SafetyGate> gate_;
  std::optional<CommandClock> command_clock_;
  std::optional<gateway::Gateway> gateway_;
  gateway::Telemetry telemetry_;
  std::array<double, vehicle::kMaxRotors> speed_{}, current_{};
  PlantPublisher publisher_;
  CommandInbox inbox_;
  StartPermission permission_;
  std::optional<PeriodKeeper> keeper_;
  LoopPageFaults page_faults_;  ///< since the rotors were armed
  std::optional<gateway::GateState> told_;
  std::uint64_t missed_told_ = 0;
  double next_missed_s_ = -1e300;
  std::string summary_file_, told_words_;
  bool operator_arms_ = false;
  double arming_timeout_ = 600;
  std::atomic<bool> arm_asked_{false};
  bus::Message<DiagnosticArray> gate_message_;
  std::optional<bus::Publisher<DiagnosticArray>> gate_publisher_;
  std::optional<double> battery_;  ///< V, newest
  std::atomic<safety::Action> failsafe_action_{safety::Action::fly};
  std::atomic<safety::Wish> wish_{safety::Wish::none};
  std::mutex failsafe_mutex_;
  std::string failsafe_words_;  ///< guarded by failsafe_mutex_
  SilenceLog silences_;
  std::optional<bus::HeartbeatWatch> watch_;
  std::optional<bus::Subscription<DiagnosticArray>> failsafe_;
  std::optional<bus::Subscription<msgs::std_msgs::String>> wish_subscription_;
};

}  // namespace

std::unique_ptr<bus::Component> make_gateway() { return std::make_unique<GatewayComponent>(); }

}  // namespace omniflight::components
