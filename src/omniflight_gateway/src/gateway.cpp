#include "omniflight_gateway/gateway.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace omniflight::gateway {
namespace {

std::uint32_t period_us(double rate_hz) {
  return rate_hz > 0 ? static_cast<std::uint32_t>(std::lround(1e6 / rate_hz)) : 0u;
}
/// The boards' clock of a stream that is off is never used, but must be defined.
double clock_rate(double rate_hz) { return rate_hz > 0 ? rate_hz : 1.0; }

}  // namespace

std::string_view to_string(GatewayPhase phase) {
  static constexpr std::array<std::string_view, 6> names = {"closed",   "identifying", "connected",
                                                            "starting", "running",     "failed"};
  return names[static_cast<std::size_t>(phase)];
}

Gateway::Gateway(GatewayConfig config) : config_(std::move(config)) {
  for (const auto& port : config_.boards) {
    LinkConfig link = config_.link;
    link.device = port.device;
    boards_.push_back({BoardLink(std::move(link)), port, 0, 0, SequenceClock(clock_rate(config_.imu_rate_hz)),
                       SequenceClock(clock_rate(config_.magnetic_rate_hz))});
  }
  rotors_.assign(config_.rotors, {SequenceClock(clock_rate(config_.motor_rate_hz)), false, false, 0});
}

Result<Gateway> Gateway::create(GatewayConfig config) {
  const std::string next = "Set it in the gateway's parameters";
  if (config.boards.empty() || config.boards.size() > 16) {
    return bad_input("must name 1 to 16 devices", "boards", next);
  }
  for (std::size_t i = 0; i < config.boards.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (config.boards[i].device == config.boards[j].device) {
        return bad_input("two boards have the device " + config.boards[i].device, "boards", next);
      }
    }
    if (config.boards[i].rotors > 15)
      return bad_input("a board drives at most 15 rotors", "boards.rotors", next);
  }
  if (config.rotors == 0 || config.rotors > 64) return bad_input("must be 1 to 64", "rotors", next);
  const std::pair<const char*, double> rates[] = {{"imu_rate_hz", config.imu_rate_hz},
                                                  {"magnetic_rate_hz", config.magnetic_rate_hz},
                                                  {"motor_rate_hz", config.motor_rate_hz},
                                                  {"battery_rate_hz", config.battery_rate_hz}};
  for (const auto& [field, rate] : rates) {
    if (!(rate == 0 || (rate >= 0.01 && rate <= 2000))) {
      return bad_input("must be 0 (off) or 0.01 to 2000 Hz, is " + std::to_string(rate), field, next);
    }
  }
  return Gateway(std::move(config));
}

Status Gateway::connect(double now_s) {
  close();
  error_.reset();
  emergency_ = false;
  last_force_.reset();
  for (auto& r : rotors_) {
    r.clock.restart();
    r.spinning = r.starting = false;
    r.emergency_frames = 0;
  }
  phase_ = GatewayPhase::identifying;
  for (auto& b : boards_) {
    b.motors = 0;
    b.imu_clock.restart();
    b.magnetic_clock.restart();
    if (auto ok = b.link.open(now_s); !ok) {
      fail_with(ok.error());
      return ok;
    }
  }
  return {};
}

void Gateway::close() {
  if (connected()) (void)stop_motors();
  for (auto& b : boards_) b.link.close();
  received_.clear();
  phase_ = GatewayPhase::closed;
}

void Gateway::fail_with(const Error& error) {
  if (!error_) error_ = error;
  phase_ = GatewayPhase::failed;
}

void Gateway::wait(double timeout_s) const {
  std::array<int, 16> fds{};
  std::size_t n = 0;
  for (const auto& b : boards_) {
    if (b.link.is_open()) fds[n++] = b.link.fd();
  }
  wait_readable({fds.data(), n}, timeout_s);
}

Status Gateway::poll(double now_s, double timeout_s) {
  if (!std::isfinite(now_s)) return bad_input("time is not finite", "Gateway::poll", "Check the clock");
  if (phase_ == GatewayPhase::closed) return bad_input("is not connected", "gateway", "Call connect first");
  if (timeout_s > 0) wait(timeout_s);
  for (auto& b : boards_) {
    received_.clear();
    const Status ok = b.link.poll(now_s, received_);
    for (const auto& message : received_) take(b, message, now_s);
    if (!ok) fail_with(ok.error());
  }
  if (phase_ == GatewayPhase::identifying &&
      std::all_of(boards_.begin(), boards_.end(), [](const Board& b) { return b.link.identified(); })) {
    if (auto ok = assign_roles(now_s); !ok) fail_with(ok.error());
  }
  if (phase_ == GatewayPhase::starting) {
    if (auto ok = keep_starting(now_s); !ok) fail_with(ok.error());
  }
  if (error_) return Failure(*error_);
  return {};
}

Status Gateway::assign_roles(double now_s) {
  std::size_t next = 0;
  std::vector<bool> taken(config_.rotors, false);
  std::string found;
  for (auto& b : boards_) {
    found += (found.empty() ? "" : ", ") + b.link.id();
    if (!has_motors(b.link.kind())) continue;
    b.offset = b.port.rotor_offset.value_or(next);
    b.motors = b.port.rotors;
    next = b.offset + b.motors;
    for (std::size_t k = b.offset; k < next; ++k) {
      if (k >= taken.size() || taken[k]) {
        return bad_input("rotor " + std::to_string(k) + " is claimed twice or beyond the vehicle's " +
                             std::to_string(config_.rotors),
                         b.port.device, "Set boards.rotors and boards.rotor_offset to the wiring");
      }
      taken[k] = true;
    }
  }
  const auto missing = std::find(taken.begin(), taken.end(), false);
  if (missing != taken.end()) {
    return bad_input("no board drives rotor " + std::to_string(missing - taken.begin()) + "; found " + found,
                     "boards", "Name the devices of all motor boards");
  }
  if (config_.imu_rate_hz > 0 &&
      std::none_of(boards_.begin(), boards_.end(), [](const Board& b) { return has_imu(b.link.kind()); })) {
    return bad_input("no board has an IMU; found " + found, "boards", "Name the device of the chimera board");
  }
  return begin_streams(now_s);
}

Status Gateway::begin_streams(double now_s) {
  using enum StreamRequest::Stream;
  const bool any_imu =
      std::any_of(boards_.begin(), boards_.end(), [](const Board& b) { return has_imu(b.link.kind()); });
  bool battery_asked = false;
  for (auto& b : boards_) {
    double fastest_hz = 0.0;
    const auto request = [&](StreamRequest::Stream stream, double rate_hz) {
      fastest_hz = std::max(fastest_hz, rate_hz);
      return b.link.send(StreamRequest{stream, period_us(rate_hz)});
    };
    Status ok;
    if (has_imu(b.link.kind())) {
      ok = request(imu, config_.imu_rate_hz);
      if (ok) ok = request(magnetometer, config_.magnetic_rate_hz);
    }
    if (ok && b.motors > 0) ok = request(motor, config_.motor_rate_hz);
    if (ok && !battery_asked && (has_imu(b.link.kind()) || !any_imu)) {
      battery_asked = true;
      ok = request(battery, config_.battery_rate_hz);
    }
    if (!ok) return ok;
    // A board that speaks less often than this cannot be told from a dead one.
    if (fastest_hz * b.link.config().silence_s > 2) b.link.expect_traffic(now_s);
  }
  phase_ = GatewayPhase::connected;
  return {};
}

Status Gateway::start_motors(double now_s) {
  if (phase_ != GatewayPhase::connected) {
    return bad_input("cannot start motors while " + std::string(to_string(phase_)), "gateway",
                     "Connect first");
  }
  if (config_.motor_rate_hz == 0) {
    return bad_input("must be on to see that the motors spin", "motor_rate_hz", "Set it to 100 Hz");
  }
  phase_ = GatewayPhase::starting;
  for (auto& r : rotors_) r.spinning = r.starting = false;
  start_begun_s_ = now_s;
  start_sent_s_ = now_s - config_.start_retry_s;
  return {};
}

Status Gateway::keep_starting(double now_s) {
  std::string waiting;
  for (std::size_t k = 0; k < rotors_.size(); ++k) {
    if (!rotors_[k].spinning) waiting += " " + std::to_string(k + 1);
  }
  if (waiting.empty()) {
    phase_ = GatewayPhase::running;
    return {};
  }
  if (now_s - start_begun_s_ > config_.start_deadline_s) {
    (void)stop_motors();
    return bad_input("did not start within " + std::to_string(config_.start_deadline_s) + " s",
                     "rotors" + waiting, "Check the motors' power and wiring");
  }
  if (now_s - start_sent_s_ < config_.start_retry_s) return {};
  start_sent_s_ = now_s;
  for (auto& b : boards_) {
    for (std::size_t k = 0; k < b.motors; ++k) {
      const Rotor& r = rotors_[b.offset + k];
      if (r.spinning || r.starting) continue;
      if (auto ok = b.link.send(StartMotor{static_cast<std::uint8_t>(k + 1)}); !ok) return ok;
    }
  }
  return {};
}

Status Gateway::stop_motors() {
  Status result;
  for (auto& b : boards_) {
    if (!b.link.is_open() || b.motors == 0) continue;
    if (auto ok = b.link.send(StopMotors{}); !ok) result = ok;
  }
  if (connected()) phase_ = GatewayPhase::connected;
  return result;
}

Status Gateway::send_velocities(std::span<const double> speeds_radps) {
  if (phase_ != GatewayPhase::running && phase_ != GatewayPhase::failed) {
    return bad_input("motors are not running, the gateway is " + std::string(to_string(phase_)), "gateway",
                     "Start the motors first");
  }
  if (speeds_radps.size() != rotors_.size()) {
    return bad_input("got " + std::to_string(speeds_radps.size()) + " speeds for " +
                         std::to_string(rotors_.size()) + " rotors",
                     "gateway", "Send one speed per rotor");
  }
  if (!std::all_of(speeds_radps.begin(), speeds_radps.end(), [](double s) { return std::isfinite(s); })) {
    return bad_input("a rotor speed is not finite", "gateway", "Pass commands through the safety gate");
  }
  for (auto& b : boards_) {
    if (b.motors == 0 || !b.link.is_open()) continue;
    VelocityCommand command;
    command.half_period_us.size = b.motors;
    for (std::size_t k = 0; k < b.motors; ++k) {
      command.half_period_us.values[k] = half_period_from_speed(speeds_radps[b.offset + k]);
    }
    if (auto ok = b.link.send(command); !ok) fail_with(ok.error());
  }
  ++commands_;
  if (error_) return Failure(*error_);
  return {};
}

Result<PidGains> to_counts(const BoardGains& gains, std::uint8_t id) {
  PidGains out;
  out.id = id;
  struct Field {
    const char* name;
    double value;
    std::uint16_t* to;
  };
  for (const Field& field : {Field{"kp", gains.kp, &out.kp}, Field{"ki", gains.ki, &out.ki},
                             Field{"kd", gains.kd, &out.kd}, Field{"f", gains.f, &out.f}}) {
    const double counts = std::round(field.value * kPidScale);
    if (!(counts >= 0 && counts <= 65535) || (field.value > 0 && counts == 0))
      return bad_input("is " + std::to_string(field.value) + ", the boards take 0 or 0.0001 to 6.5535",
                       field.name, "Choose other gains, or a longer control period");
    *field.to = static_cast<std::uint16_t>(counts);
  }
  return out;
}

Status Gateway::send_gains(std::size_t rotor, const BoardGains& gains) {
  if (!connected())
    return bad_input("cannot send gains while " + std::string(to_string(phase_)), "gateway", "Connect first");
  for (auto& b : boards_) {
    if (rotor < b.offset || rotor >= b.offset + b.motors) continue;
    const auto counts = to_counts(gains, static_cast<std::uint8_t>(rotor - b.offset + 1));
    if (!counts) return Failure(counts.error());
    return b.link.send(*counts);
  }
  return bad_input("there is no rotor " + std::to_string(rotor + 1), "gateway",
                   "Count from 1 to the vehicle's rotors");
}

std::size_t Gateway::spinning_rotors() const {
  return static_cast<std::size_t>(
      std::count_if(rotors_.begin(), rotors_.end(), [](const Rotor& r) { return r.spinning; }));
}

GatewayStatistics Gateway::statistics() const {
  GatewayStatistics s;
  for (const auto& b : boards_) {
    const auto& d = b.link.decoder_statistics();
    s.frames += d.frames;
    s.refused_frames += d.refused();
    s.stray_bytes += d.stray_bytes;
    s.refused_messages += b.link.refused_messages();
    s.commands_superseded += b.link.superseded_commands();
    s.missed_imu += b.imu_clock.missed();
  }
  for (const auto& r : rotors_) s.missed_rotor += r.clock.missed();
  s.implausible = implausible_;
  s.duplicates = duplicates_;
  s.commands_sent = commands_;
  s.telemetry_dropped = dropped_;
  return s;
}

}  // namespace omniflight::gateway
