// Every message of the telekyb3 protocol as a struct, and its body on the wire (integers big endian).
// Fields keep the wire's counts; tk3_units.hpp turns them into SI units.
#pragma once

#include <omniflight_core/result.hpp>
#include <optional>
#include <string>
#include <variant>

#include "omniflight_gateway/tk3_frame.hpp"

namespace omniflight::gateway {

// ---- host -> board

/// '?': who are you. Answered by IdReply.
struct IdQuery {};
/// 'b' 'm' 'i' 'c' 't': send this stream every period_us microseconds, 0 = off.
struct StreamRequest {
  enum class Stream : char { battery = 'b', motor = 'm', imu = 'i', magnetometer = 'c', clock = 't' };
  Stream stream = Stream::imu;
  std::uint32_t period_us = 0;
};
/// 'g': start motor id (1-based on its board).
struct StartMotor {
  std::uint8_t id = 1;
};
/// 'x': stop one motor, or all.
struct StopMotors {
  std::optional<std::uint8_t> id;
};
/// As many int16 as one body can carry.
struct Counts {
  std::array<std::int16_t, (kMaxBody - 1) / 2> values{};
  std::size_t size = 0;
};
/// 'w': half-periods [us, signed] of motors 1, 2, ...
struct VelocityCommand {
  Counts half_period_us;
};
/// 'q': open-loop throttle of motors 1, 2, ..., +-1023 = +-100 %.
struct ThrottleCommand {
  Counts throttle;
};
/// '%': speed loop gains of one motor, each times 10000.
struct PidGains {
  std::uint8_t id = 1;
  std::uint16_t kp = 0, ki = 0, kd = 0, f = 0;
};
/// "gains ID: KP KI KD F" in counts: how the emulated board tells what it was sent. The protocol has no
/// message for it.
std::string gains_text(const PidGains& gains);
/// '~': beep at this frequency, 0 = silent.
struct Beep {
  std::uint16_t frequency_Hz = 0;
};
using HostMessage = std::variant<IdQuery, StreamRequest, StartMotor, StopMotors, VelocityCommand,
                                 ThrottleCommand, PidGains, Beep>;

// ---- board -> host

/// '?' + name and version, for instance "teensy1.2".
struct IdReply {
  std::string text;
};
/// 'I': specific force and angular velocity in the board's counts.
struct ImuData {
  std::uint8_t seq = 0;
  std::array<std::int16_t, 3> acceleration{}, gyro{};
};
/// 'C': magnetic field, 1e-8 T.
struct MagData {
  std::uint8_t seq = 0;
  std::array<std::int16_t, 3> field{};
};
/// 'M': one motor.
struct MotorData {
  std::uint8_t seq = 0;
  std::uint8_t id = 1;  ///< 1..15 on its board
  bool emergency = false, spinning = false, starting = false;
  std::int16_t half_period_us = 0;
  std::int16_t throttle = 0;  ///< 1023 = 100 %
  std::uint16_t current_mA = 0;
};
/// 'B'
struct BatteryData {
  std::uint8_t seq = 0;
  std::uint16_t voltage_mV = 0;
};
/// 'T': clock rate of one motor controller.
struct ClockRate {
  std::uint8_t id = 1;
  std::uint8_t rate = 0;
};
/// 'N' 'A' 'E' + text.
struct BoardText {
  enum class Severity : char { info = 'N', warning = 'A', error = 'E' };
  Severity severity = Severity::info;
  std::string text;
};
using BoardMessage = std::variant<IdReply, ImuData, MagData, MotorData, BatteryData, ClockRate, BoardText>;

/// Body of a message. Texts are cut at 63 bytes.
Body encode(const HostMessage& message);
Body encode(const BoardMessage& message);
/// Refuses unknown letters, wrong lengths and impossible values (motor id 0); the message says which.
Result<HostMessage> decode_host(const Body& body);
Result<BoardMessage> decode_board(const Body& body);

/// Body and framing in one step.
template <class Message>
Wire to_wire(const Message& message) {
  return encode_frame(encode(message));
}

}  // namespace omniflight::gateway
