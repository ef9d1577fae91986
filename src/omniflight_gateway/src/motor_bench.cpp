#include "omniflight_gateway/motor_bench.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace omniflight::gateway {
namespace {

constexpr double kPoll_s = 0.001;
constexpr double kWindDown_s = 2.0;
constexpr double kAnswer_s = 0.2;
constexpr double kLastWord_s = 0.05;  // for the stop to leave the line before it is closed

Status check(std::span<const double> command, const BenchConfig& c) {
  if (command.empty() || command.size() > 4'000'000)
    return bad_input("has " + std::to_string(command.size()) + " values, 1 to 4000000 are possible",
                     "command");
  if (!(c.period_s >= 0.001 && c.period_s <= 0.1))
    return bad_input("is " + std::to_string(c.period_s) + " s, 0.001 to 0.1 s are possible", "period");
  for (const double speed : command)
    if (!std::isfinite(speed) || std::abs(speed) > c.max_speed_radps)
      return bad_input("asks for " + std::to_string(speed) + " rad/s, up to " +
                           std::to_string(c.max_speed_radps) + " rad/s are allowed",
                       "command", "Lower its levels");
  return {};
}

class Bench {
 public:
  Bench(Gateway& gateway, SafetyGate gate, const BenchConfig& config, const BenchClock& clock)
      : gateway_(gateway), gate_(std::move(gate)), config_(config), clock_(clock) {}

  /// Moves on in steps of a millisecond; with `send` the gate's output goes to the boards.
  Status advance(double until_s, bool send) {
    while (clock_.now() < until_s - 1e-9) {
      if (auto ok = clock_.advance(std::min(until_s, clock_.now() + kPoll_s)); !ok) return ok;
      if (auto ok = gateway_.poll(clock_.now()); !ok) return ok;
      if (gateway_.emergency())
        return fail(ErrorCode::incomplete, "a motor reports an emergency", "board",
                    "Look at motor and propeller");
      gateway_.fetch(batch_);
      if (send) {
        const GateOutput out = gate_.update(clock_.now());
        if (out.stop_motors) return gateway_.stop_motors();
        if (auto ok = gateway_.send_velocities(out.speeds_radps); !ok) return ok;
      }
      notices_.insert(notices_.end(), batch_.notices.begin(), batch_.notices.end());
      if (recording_) {
        record_.rotors.insert(record_.rotors.end(), batch_.rotors.begin(), batch_.rotors.end());
        record_.battery.insert(record_.battery.end(), batch_.battery.begin(), batch_.battery.end());
      }
    }
    return {};
  }

  Status until(GatewayPhase phase, double limit_s, const char* what) {
    const double end = clock_.now() + limit_s;
    while (gateway_.phase() != phase) {
      if (clock_.now() > end || stopped())
        return fail(ErrorCode::incomplete, what, "boards", "Look at power, wiring and device names");
      if (auto ok = advance(clock_.now() + kPoll_s, false); !ok) return ok;
    }
    return {};
  }

  bool stopped() const { return clock_.stop && clock_.stop(); }

  /// Sends the gains and reads what the boards say of them.
  Status send_gains(std::size_t rotors) {
    if (!config_.gains) return {};
    for (std::size_t k = 0; k < rotors; ++k)
      if (auto ok = gateway_.send_gains(k, *config_.gains); !ok) return ok;
    notices_.clear();
    if (auto ok = advance(clock_.now() + kAnswer_s, false); !ok) return ok;
    for (const BoardNotice& notice : notices_) {
      if (notice.text.rfind("gains ", 0) != 0) continue;
      const auto id = static_cast<std::uint8_t>(std::strtoul(notice.text.c_str() + 6, nullptr, 10));
      const auto sent = to_counts(*config_.gains, id);
      if (!sent || notice.text != gains_text(*sent))
        return fail(ErrorCode::incomplete, "tells " + notice.text + ", which was not sent", notice.device,
                    "Look at the line, send the gains again");
      ++record_.gains_confirmed;
    }
    return {};
  }

  Status play(std::size_t rotors, std::span<const double> command) {
    std::vector<double> speeds(rotors);
    const auto offer = [&](double speed) {
      std::fill(speeds.begin(), speeds.end(), speed);
      const double now = clock_.now();
      if (gate_.offer(speeds, now, now)) ++record_.refused;
    };
    if (auto ok = gate_.arm(clock_.now()); !ok) return ok;
    const auto ramp = static_cast<std::size_t>(std::ceil(config_.ramp_s / config_.period_s));
    // a command must be younger than the arming
    if (auto ok = advance(clock_.now() + kPoll_s, true); !ok) return ok;
    double due = clock_.now();
    for (std::size_t k = 1; k <= ramp && !stopped(); ++k) {
      offer(command.front() * static_cast<double>(k) / static_cast<double>(ramp));
      if (auto ok = advance(due += config_.period_s, true); !ok) return ok;
    }
    start_s_ = clock_.now();
    recording_ = true;
    for (const double speed : command) {
      if (stopped()) return {};
      record_.command_s.push_back(clock_.now() - start_s_);
      record_.command_radps.push_back(speed);
      offer(speed);
      if (auto ok = advance(due += config_.period_s, true); !ok) return ok;
    }
    record_.complete = true;
    return {};
  }

  Status wind_down() {
    recording_ = false;
    gate_.trip(Trip::requested, clock_.now());
    const Status ok = advance(clock_.now() + kWindDown_s, true);
    const Status stopped_motors = gateway_.stop_motors();
    if (!ok || !stopped_motors) return ok ? stopped_motors : ok;
    return advance(clock_.now() + kLastWord_s, false);
  }

  BenchRecord take() {
    for (RotorSample& s : record_.rotors) {
      s.time_s -= start_s_;
      s.arrival_s -= start_s_;
      record_.missed += s.missed;
    }
    for (BatterySample& s : record_.battery) s.arrival_s -= start_s_;
    return std::move(record_);
  }

 private:
  Gateway& gateway_;
  SafetyGate gate_;
  const BenchConfig& config_;
  const BenchClock& clock_;
  BenchRecord record_;
  Telemetry batch_;
  std::vector<BoardNotice> notices_;
  double start_s_ = 0.0;
  bool recording_ = false;
};

}  // namespace

Result<BenchRecord> run_motor_bench(Gateway& gateway, std::size_t rotors, std::span<const double> command,
                                    const BenchConfig& config, const BenchClock& clock) {
  if (auto ok = check(command, config); !ok) return Failure(ok.error());
  auto gate = SafetyGate::create({.rotors = rotors,
                                  .max_speed_radps = config.max_speed_radps,
                                  .max_acceleration_radps2 = config.max_acceleration_radps2,
                                  .fresh_for_s = config.period_s + 0.005,
                                  .stale_after_s = std::max(0.1, 2 * config.period_s)});
  if (!gate) return Failure(gate.error());
  Bench bench(gateway, std::move(*gate), config, clock);
  const auto run = [&]() -> Status {
    if (auto ok = gateway.connect(clock.now()); !ok) return ok;
    if (auto ok = bench.until(GatewayPhase::connected, config.connect_s, "the boards do not answer"); !ok)
      return ok;
    if (auto ok = bench.send_gains(rotors); !ok) return ok;
    if (auto ok = gateway.start_motors(clock.now()); !ok) return ok;
    if (auto ok = bench.until(GatewayPhase::running, config.connect_s + 1, "the motors do not start"); !ok)
      return ok;
    return bench.play(rotors, command);
  };
  const Status played = run();
  const Status ended =
      gateway.connected() || gateway.phase() == GatewayPhase::failed ? bench.wind_down() : Status{};
  gateway.close();
  if (!played) return Failure(played.error());
  if (!ended) return Failure(ended.error());
  return bench.take();
}

}  // namespace omniflight::gateway
