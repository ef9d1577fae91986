// What the gateway makes of messages that arrive: plausibility, host time, SI units, global ids.
#include <cmath>

#include "omniflight_gateway/gateway.hpp"

namespace omniflight::gateway {
namespace {

constexpr std::size_t kTelemetryLimit = 8192;  // samples of a kind that wait for fetch()

}  // namespace

template <class Sample>
void Gateway::store(std::vector<Sample>& list, Sample sample) {
  if (list.size() < kTelemetryLimit) {
    list.push_back(std::move(sample));
  } else {
    ++dropped_;
  }
}

bool Gateway::plausible(const Vec3& specific_force) {
  // Three in a row agree with each other rather than with the past: then the past was wrong.
  const bool ok =
      !last_force_ || implausible_in_a_row_ >= 3 ||
      (specific_force - *last_force_).cwiseAbs().maxCoeff() <= config_.plausible_specific_force_step;
  implausible_in_a_row_ = ok ? 0 : implausible_in_a_row_ + 1;
  if (ok) last_force_ = specific_force;
  return ok;
}

void Gateway::take_imu(Board& board, const ImuData& m, double now_s) {
  if (!has_imu(board.link.kind())) {
    ++implausible_;
    return;
  }
  const ImuScale scale = imu_scale(board.link.kind());
  ImuSample s;
  for (int i = 0; i < 3; ++i) {
    s.specific_force_B[i] = m.acceleration[static_cast<std::size_t>(i)] * scale.acceleration;
    s.w_WB_B[i] = m.gyro[static_cast<std::size_t>(i)] * scale.gyro;
  }
  if (!plausible(s.specific_force_B)) {
    ++implausible_;
    return;
  }
  const auto stamp = board.imu_clock.stamp(m.seq, now_s);
  if (stamp.duplicate) {
    ++duplicates_;
    return;
  }
  s.time_s = stamp.time_s;
  s.arrival_s = now_s;
  s.seq = m.seq;
  s.missed = stamp.missed;
  store(telemetry_.imu, s);
}

void Gateway::take_motor(Board& board, const MotorData& m, double now_s) {
  const double speed = m.spinning ? speed_from_half_period(m.half_period_us) : 0.0;
  if (m.id > board.motors || std::abs(speed) > config_.plausible_speed_radps) {
    ++implausible_;
    return;
  }
  const std::size_t global = board.offset + m.id - 1u;
  Rotor& rotor = rotors_[global];
  const auto stamp = rotor.clock.stamp(m.seq, now_s);
  if (stamp.duplicate) {
    ++duplicates_;
    return;
  }
  rotor.spinning = m.spinning;
  rotor.starting = m.starting;
  // No checksum on this line: one frame alone may be noise.
  rotor.emergency_frames = m.emergency ? rotor.emergency_frames + 1 : 0;
  emergency_ = emergency_ || rotor.emergency_frames >= 2;
  RotorSample s;
  s.time_s = stamp.time_s;
  s.arrival_s = now_s;
  s.seq = m.seq;
  s.missed = stamp.missed;
  s.rotor = global;
  s.speed_radps = speed;
  s.throttle = m.throttle / kThrottleFull;
  s.current_A = m.current_mA * kMilli;
  s.starting = m.starting;
  s.spinning = m.spinning;
  s.emergency = m.emergency;
  store(telemetry_.rotors, s);
}

void Gateway::take(Board& board, const BoardMessage& message, double now_s) {
  if (!connected() && phase_ != GatewayPhase::failed) return;  // streams of an earlier session
  if (const auto* imu = std::get_if<ImuData>(&message)) {
    take_imu(board, *imu, now_s);
  } else if (const auto* motor = std::get_if<MotorData>(&message)) {
    take_motor(board, *motor, now_s);
  } else if (const auto* mag = std::get_if<MagData>(&message)) {
    const auto stamp = board.magnetic_clock.stamp(mag->seq, now_s);
    if (stamp.duplicate) {
      ++duplicates_;
      return;
    }
    MagneticSample s{stamp.time_s, now_s, mag->seq, {}};
    for (int i = 0; i < 3; ++i) s.field_B[i] = mag->field[static_cast<std::size_t>(i)] * kMagneticLsb;
    store(telemetry_.magnetic, s);
  } else if (const auto* battery = std::get_if<BatteryData>(&message)) {
    store(telemetry_.battery, {now_s, battery->voltage_mV * kMilli});
  } else if (const auto* text = std::get_if<BoardText>(&message)) {
    store(telemetry_.notices, {now_s, board.port.device, text->severity, text->text});
  }
}

void Gateway::fetch(Telemetry& telemetry) {
  telemetry.clear();
  std::swap(telemetry, telemetry_);
}

}  // namespace omniflight::gateway
