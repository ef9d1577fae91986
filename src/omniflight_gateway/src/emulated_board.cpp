#include "omniflight_gateway/emulated_board.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace omniflight::gateway {
namespace {

template <class Message>
void append(std::vector<std::uint8_t>& out, const Message& message) {
  const Wire wire = to_wire(BoardMessage(message));
  out.insert(out.end(), wire.data.begin(), wire.data.begin() + static_cast<std::ptrdiff_t>(wire.size));
}

double value_or_zero(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : 0.0;
}

/// Measured half-period: the board times whole microseconds; too slow for int16 reads as "no period".
std::int16_t measured_half_period(double speed_radps) {
  const double half_period = std::round(kPi * 1e6 / speed_radps);
  return std::abs(half_period) < kStopHalfPeriod ? static_cast<std::int16_t>(half_period) : std::int16_t{0};
}

std::uint16_t to_milli(double value) {
  return static_cast<std::uint16_t>(
      std::isfinite(value) ? std::clamp(std::round(value / kMilli), 0.0, 65535.0) : 0.0);
}

}  // namespace

void EmulatedBoard::receive(std::span<const std::uint8_t> bytes, double now_s,
                            std::vector<std::uint8_t>& out) {
  for (const std::uint8_t byte : bytes) {
    if (!decoder_.push(byte)) continue;
    const auto message = decode_host(decoder_.body());
    if (message) {
      handle(*message, now_s, out);
    } else {
      ++refused_messages_;
    }
  }
}

void EmulatedBoard::handle(const HostMessage& message, double now_s, std::vector<std::uint8_t>& out) {
  if (std::holds_alternative<IdQuery>(message)) {
    append(out, IdReply{config_.id});
  } else if (const auto* request = std::get_if<StreamRequest>(&message)) {
    const Stream fresh{request->period_us * 1e-6, now_s, 0};
    using enum StreamRequest::Stream;
    if (request->stream == imu && config_.has_imu) imu_ = fresh;
    if (request->stream == motor && !motors_.empty()) motor_ = fresh;
    if (request->stream == battery && config_.has_battery) battery_ = fresh;
  } else if (const auto* start = std::get_if<StartMotor>(&message)) {
    if (start->id > motors_.size()) {
      append(out, BoardText{BoardText::Severity::warning, "no motor " + std::to_string(start->id)});
      return;
    }
    Motor& m = motors_[start->id - 1u];
    if (m.state != MotorState::stopped) return;
    m.state = MotorState::starting;
    m.started_s = now_s;
    m.target_radps = 0.0;
  } else if (const auto* stop = std::get_if<StopMotors>(&message)) {
    for (std::size_t k = 0; k < motors_.size(); ++k) {
      if (!stop->id || *stop->id == k + 1) motors_[k].state = MotorState::stopped;
    }
    commanded_ = false;
  } else if (const auto* velocity = std::get_if<VelocityCommand>(&message)) {
    ++velocity_commands_;
    drive(velocity->half_period_us, now_s,
          [](std::int16_t v, const EmulatedBoardConfig&) { return speed_from_half_period(v); });
  } else if (const auto* throttle = std::get_if<ThrottleCommand>(&message)) {
    drive(throttle->throttle, now_s, [](std::int16_t v, const EmulatedBoardConfig& c) {
      return std::clamp(v / kThrottleFull, -1.0, 1.0) * c.full_throttle_radps;
    });
  } else if (const auto* gains = std::get_if<PidGains>(&message)) {
    if (gains->id > motors_.size()) {
      append(out, BoardText{BoardText::Severity::warning, "no motor " + std::to_string(gains->id)});
      return;
    }
    motors_[gains->id - 1u].gains = *gains;
    append(out, BoardText{BoardText::Severity::info, gains_text(*gains)});
  }
  // Beep changes nothing a plant given from outside could show.
}

void EmulatedBoard::drive(const Counts& counts, double now_s,
                          double (*to_speed)(std::int16_t, const EmulatedBoardConfig&)) {
  update(now_s);  // so that a late command meets the watchdog first
  const std::size_t n = std::min(counts.size, motors_.size());
  for (std::size_t k = 0; k < n; ++k) {
    if (motors_[k].state == MotorState::spinning)
      motors_[k].target_radps = to_speed(counts.values[k], config_);
  }
  commanded_s_ = now_s;
  commanded_ = true;
}

void EmulatedBoard::update(double now_s) {
  now_s_ = now_s;
  for (Motor& m : motors_) {
    if (m.state == MotorState::starting && now_s - m.started_s >= config_.start_time_s)
      m.state = MotorState::spinning;
  }
  if (commanded_ && ramp() <= 0.0) {
    for (Motor& m : motors_) {
      if (m.state == MotorState::spinning) m.state = MotorState::stopped;
    }
    commanded_ = false;
  }
}

double EmulatedBoard::ramp() const {
  if (!commanded_) return 1.0;
  const double silent_s = now_s_ - commanded_s_;
  if (silent_s <= config_.watchdog_s) return 1.0;
  return 1.0 - (silent_s - config_.watchdog_s) / config_.ramp_down_s;
}

double EmulatedBoard::target(std::size_t k) const {
  if (motors_[k].state != MotorState::spinning) return 0.0;
  return motors_[k].target_radps * std::clamp(ramp(), 0.0, 1.0);
}

bool EmulatedBoard::any_motor_on() const {
  return std::any_of(motors_.begin(), motors_.end(), [](const Motor& m) {
    return m.state == MotorState::spinning || m.state == MotorState::starting;
  });
}

void EmulatedBoard::fail_motor(std::size_t k) { motors_[k].state = MotorState::emergency; }

bool EmulatedBoard::due(Stream& stream, double now_s) {
  constexpr double kHalfMicrosecond = 0.5e-6;  // sums of periods and the caller's steps round differently
  if (stream.period_s <= 0.0 || now_s + kHalfMicrosecond < stream.due_s) return false;
  stream.due_s += stream.period_s;
  if (stream.due_s + stream.period_s < now_s) stream.due_s = now_s + stream.period_s;
  return true;
}

void EmulatedBoard::emit(double now_s, const PlantSample& sample, std::vector<std::uint8_t>& out) {
  if (due(imu_, now_s)) {
    ImuData m;
    m.seq = imu_.seq++;
    for (int i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      m.acceleration[at] = to_lsb(sample.specific_force_B[i], config_.imu_scale.acceleration);
      m.gyro[at] = to_lsb(sample.w_WB_B[i], config_.imu_scale.gyro);
    }
    append(out, m);
  }
  if (due(motor_, now_s)) {
    for (std::size_t k = 0; k < motors_.size(); ++k) {
      Motor& motor = motors_[k];
      const std::size_t global = config_.rotor_offset + k;
      MotorData m;
      m.seq = motor.seq++;
      m.id = static_cast<std::uint8_t>(k + 1);
      m.emergency = motor.state == MotorState::emergency;
      m.spinning = motor.state == MotorState::spinning;
      m.starting = motor.state == MotorState::starting;
      m.half_period_us = measured_half_period(value_or_zero(sample.rotor_speed_radps, global));
      const double throttle = global < sample.rotor_throttle.size() ? sample.rotor_throttle[global]
                                                                    : target(k) / config_.full_throttle_radps;
      m.throttle = to_lsb(throttle, 1.0 / kThrottleFull);
      m.current_mA = to_milli(value_or_zero(sample.rotor_current_A, global));
      append(out, m);
    }
  }
  if (due(battery_, now_s)) append(out, BatteryData{battery_.seq++, to_milli(sample.battery_V)});
}

}  // namespace omniflight::gateway
