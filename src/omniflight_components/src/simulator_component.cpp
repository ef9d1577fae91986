// The simulated plant on the bus, clock master of a flight. In lockstep a tick ends when the command for it
// has arrived; in real time a watchdog stops the rotors when commands go stale.
#include <atomic>

#include "command_clock.hpp"
#include "command_inbox.hpp"
#include "conversions.hpp"
#include "factories.hpp"
#include "failsafe_message.hpp"
#include "omniflight_simulation/faults.hpp"
#include "plant_parameters.hpp"
#include "plant_publisher.hpp"
#include "threaded_component.hpp"

namespace omniflight::components {
namespace {

using namespace std::chrono_literals;
using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::omniflight_msgs::RecorderState;

class Simulator final : public ThreadedComponent {
 public:
  Simulator() : ThreadedComponent("simulator") {}
  ~Simulator() override { stop(); }

 private:
  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "simulator");
    lockstep_ = p.text("rate", "max") != "realtime";
    recorder_window_ = static_cast<std::uint64_t>(p.integer("recorder_window_ticks", 0, 0, 100000));
    command_timeout_ = p.number("command_timeout_s", 2.0, 0.01, 60.0);
    stale_after_ = p.number("stale_after_s", 0.3, 0.005, 10.0);
    const std::string faults_file = p.text("faults_file", "");
    auto read = read_plant_parameters(p);
    if (!read) return Failure(read.error());
    parameters_ = std::move(*read);
    command_clock_.emplace("simulator", parameters_.control_period, stale_after_);
    faults_.reset();
    if (!faults_file.empty()) {
      auto faults = simulation::load_faults(faults_file, parameters_.vehicle.rotor_count());
      if (!faults) return Failure(faults.error());
      faults_.emplace(std::move(*faults));
    }
    if (auto ok = make_plant(parameters_, plant_, sensors_); !ok) return ok;
    if (auto ok = create_publishers(publisher_, parameters_.vehicle.rotor_count(), PlantPublisher::Part::all);
        !ok)
      return ok;
    if (recorder_window_ > 0) {
      auto made = bus::Subscription<RecorderState>::create(
          participant(), topics::recorder, bus::Qos::control(),
          [this](const RecorderState& m, std::int64_t) { recorded_ticks_.store(m.ticks_seen); });
      if (!made) return Failure(made.error());
      recorder_.emplace(std::move(*made));
    }
    auto failsafe =
        bus::Subscription<DiagnosticArray>::create(participant(), topics::failsafe, bus::Qos::latched_last(4),
                                                   [this](const DiagnosticArray& m, std::int64_t) {
                                                     if (failsafe_action(m) >= safety::Action::ramp_down)
                                                       failsafe_ended_.store(true);
                                                   });
    if (!failsafe) return Failure(failsafe.error());
    failsafe_.emplace(std::move(*failsafe));
    if (lockstep_) inbox_.answer_up_to(-1);  // there is no tick yet
    return inbox_.subscribe(participant());
  }

  Status on_cleanup() override {
    stop();
    recorder_.reset();
    failsafe_.reset();
    inbox_.unsubscribe();
    publisher_.destroy();
    return {};
  }

  /// Waits until whoever must be there is there.
  Status meet_peers() {
    const std::uint32_t listeners = recorder_window_ > 0 ? 2 : 1;
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(parameters_.peers_timeout);
    for (;;) {
      const auto heard = std::min(publisher_.tick_publisher().peers(), publisher_.sensor_peers());
      const bool commanded = inbox_.subscription().peers() > 0;
      const bool recorded = recorder_window_ == 0 || recorder_->peers() > 0;
      if (heard >= listeners && commanded && recorded) {
        std::this_thread::sleep_for(50ms);  // the other side may know a few milliseconds later
        return {};
      }
      if (!running()) return fail(ErrorCode::incomplete, "stopped before the flight began", "simulator");
      if (std::chrono::steady_clock::now() > deadline)
        return fail(
            ErrorCode::incomplete,
            std::string("waited ") + std::to_string(parameters_.peers_timeout) + " s for " +
                (!commanded ? "an allocator that publishes commands"
                            : (heard < listeners ? "a controller that follows the ticks" : "a recorder")),
            "simulator", "Start the missing component in the same domain");
      std::this_thread::sleep_for(10ms);
    }
  }

  /// In lockstep: the command for this tick, or an error once the deadline has passed.
  Status obey(std::int64_t stamp_ns) {
    RotorCommand command;
    if (lockstep_) {
      // At the first tick controller and allocator may still be looking for each other.
      const double patience =
          stamp_ns > 0 ? command_timeout_ : std::max(command_timeout_, parameters_.peers_timeout);
      const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
      for (int waited = 1; !inbox_.wait_for(stamp_ns, 50ms, command); ++waited) {
        if (!running()) return fail(ErrorCode::incomplete, "stopped in flight", "simulator");
        // components may have met after one of them answered, which nobody heard then
        if (waited % 6 == 0)
          if (auto ok = publisher_.repeat_tick(); !ok) return ok;
        if (std::chrono::steady_clock::now() > deadline) {
          (void)publisher_.tick(plant_->time(), parameters_.control_period, FlightPhase::ended);
          return fail(ErrorCode::incomplete,
                      "no command for the tick at " + std::to_string(to_s(stamp_ns)) +
                          " s of simulated time (last: " + std::to_string(to_s(command.stamp_ns)) +
                          " s); the rotors are stopped",
                      "simulator", "See whether controller and allocator are still alive");
        }
      }
    } else {
      command = inbox_.newest();
      const double now = to_s(stamp_ns);
      if (command.number != commands_taken_) {
        commands_taken_ = command.number;
        const double taken = command_clock_->place(command.stamp_ns, now, command_believed_);
        if (command_believed_) commanded_at_ = taken;
      }
      if (!command_believed_) command.count = 0;
      if (!commanded_at_ && now < parameters_.hold) return {};
      const double age = commanded_at_ ? now - *commanded_at_ : now;
      if (age > stale_after_) {
        (void)publisher_.tick(plant_->time(), parameters_.control_period, FlightPhase::ended);
        return fail(ErrorCode::incomplete,
                    "the newest command is " + std::to_string(age) + " s old; the rotors are stopped",
                    "simulator", "See whether controller and allocator are still alive");
      }
    }
    if (command.count > 0 && !plant_->set_command({command.speed.data(), command.count}, command.alpha))
      return fail(ErrorCode::internal,
                  "the allocator commands a speed that is not finite or has the wrong count", "simulator");
    return {};
  }

  /// The controller's failsafe winds the rotors down: without a gate in between the flight ends here.
  Status failsafe_end() {
    (void)publisher_.tick(plant_->time(), parameters_.control_period, FlightPhase::ended);
    (void)follow_recorder(0);
    return fail(
        ErrorCode::incomplete,
        "the failsafe ended the flight at " + std::to_string(plant_->time()) + " s; the rotors are stopped",
        "simulator", "See /omniflight/failsafe in the recording, or the controller's log");
  }

  /// Waits while the recorder is more than `window` ticks behind.
  Status follow_recorder(std::uint64_t window) {
    if (recorder_window_ == 0 || !lockstep_) return {};
    const auto deadline = std::chrono::steady_clock::now() + 10s;
    while (publisher_.ticks() > recorded_ticks_.load() + window) {
      if (!running()) return fail(ErrorCode::incomplete, "stopped in flight", "simulator");
      if (std::chrono::steady_clock::now() > deadline)
        return fail(ErrorCode::incomplete, "the recorder has not kept up for 10 s", "simulator",
                    "See whether the recorder is alive and its disk is not full");
      std::this_thread::sleep_for(100us);
    }
    return {};
  }

  /// Sleeps until simulated time t [s] is due. Time that the machine slept through is left out, not made up
  /// for: a burst of ticks would find every command stale.
  void pace(double t) {
    const auto due =
        start_ + std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(t));
    const auto now = std::chrono::steady_clock::now();
    if (now > due + 20ms) start_ += now - due;
    std::this_thread::sleep_until(due);
  }

  Status run() override {
    if (auto ok = meet_peers(); !ok) return ok;
    start_ = std::chrono::steady_clock::now();
    const auto steps_a_tick =
        static_cast<std::uint64_t>(std::llround(parameters_.control_period / parameters_.plant.step));
    const auto steps = static_cast<std::uint64_t>(std::ceil(parameters_.duration / parameters_.plant.step));
    simulation::SensorFrame frame;
    for (std::uint64_t k = 0; k <= steps; ++k) {
      if (!running()) return fail(ErrorCode::incomplete, "stopped in flight", "simulator");
      const double t = plant_->time();
      const bool held = t < parameters_.hold - 1e-9;
      sensors_->sample(*plant_, frame);
      if (faults_) faults_->alter(t, frame);
      if (auto ok = publisher_.frame(frame, *plant_); !ok) return ok;
      if (k % steps_a_tick == 0) {
        if (auto ok = publisher_.truth(*plant_); !ok) return ok;
        const bool last = k + steps_a_tick > steps;
        if (!lockstep_) pace(t);
        if (lockstep_) inbox_.answer_up_to(to_ns(t));
        if (auto ok =
                publisher_.tick(t, parameters_.control_period,
                                last ? FlightPhase::ended : (held ? FlightPhase::held : FlightPhase::free));
            !ok)
          return ok;
        if (last) return follow_recorder(0);  // nobody ends before everything is recorded
        if (auto ok = obey(to_ns(t)); !ok) return ok;
        if (failsafe_ended_.load()) return failsafe_end();
        if (auto ok = follow_recorder(recorder_window_); !ok) return ok;
      }
      if (faults_) faults_->before_step(*plant_);
      if (auto ok = plant_->step(held); !ok) {
        (void)publisher_.tick(plant_->time(), parameters_.control_period, FlightPhase::ended);
        return ok;
      }
    }
    return {};
  }

  PlantParameters parameters_;
  std::optional<simulation::Plant> plant_;
  std::optional<simulation::SensorSuite> sensors_;
  std::optional<simulation::FaultInjector> faults_;
  PlantPublisher publisher_;
  CommandInbox inbox_;
  std::optional<bus::Subscription<RecorderState>> recorder_;
  std::optional<bus::Subscription<DiagnosticArray>> failsafe_;
  std::atomic<bool> failsafe_ended_{false};
  std::atomic<std::uint64_t> recorded_ticks_{0};
  std::optional<CommandClock> command_clock_;  ///< in real time
  std::optional<double> commanded_at_;         ///< s, flight time of the newest believed command
  std::uint64_t commands_taken_ = 0;
  bool command_believed_ = false;
  std::uint64_t recorder_window_ = 0;
  std::chrono::steady_clock::time_point start_;  ///< when simulated time 0 was due
  bool lockstep_ = true;
  double command_timeout_ = 2.0, stale_after_ = 0.3;
};

}  // namespace

std::unique_ptr<bus::Component> make_simulator() { return std::make_unique<Simulator>(); }

}  // namespace omniflight::components
