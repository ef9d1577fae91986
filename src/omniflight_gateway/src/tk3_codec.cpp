#include "omniflight_gateway/tk3_codec.hpp"

#include "body_io.hpp"

namespace omniflight::gateway {
namespace {

constexpr std::uint8_t kEmergency = 0x80, kSpinning = 0x20, kStarting = 0x10, kIdMask = 0x0f;

Body write(const IdQuery&) { return BodyWriter('?').body; }
Body write(const StreamRequest& m) { return BodyWriter(static_cast<char>(m.stream)).u32(m.period_us).body; }
Body write(const StartMotor& m) { return BodyWriter('g').u8(m.id).body; }
Body write(const StopMotors& m) { return m.id ? BodyWriter('x').u8(*m.id).body : BodyWriter('x').body; }
Body write_counts(char letter, const Counts& counts) {
  BodyWriter w(letter);
  for (std::size_t i = 0; i < counts.size; ++i) w.i16(counts.values[i]);
  return w.body;
}
Body write(const VelocityCommand& m) { return write_counts('w', m.half_period_us); }
Body write(const ThrottleCommand& m) { return write_counts('q', m.throttle); }
Body write(const PidGains& m) { return BodyWriter('%').u8(m.id).u16(m.kp).u16(m.ki).u16(m.kd).u16(m.f).body; }
Body write(const Beep& m) { return BodyWriter('~').u16(m.frequency_Hz).body; }

Body write(const IdReply& m) { return BodyWriter('?').text(m.text).body; }
Body write(const ImuData& m) {
  BodyWriter w('I');
  w.u8(m.seq);
  for (const auto v : m.acceleration) w.i16(v);
  for (const auto v : m.gyro) w.i16(v);
  return w.body;
}
Body write(const MagData& m) {
  BodyWriter w('C');
  w.u8(m.seq);
  for (const auto v : m.field) w.i16(v);
  return w.body;
}
Body write(const MotorData& m) {
  const unsigned state = (m.emergency ? kEmergency : 0u) | (m.spinning ? kSpinning : 0u) |
                         (m.starting ? kStarting : 0u) | (m.id & kIdMask);
  return BodyWriter('M')
      .u8(m.seq)
      .u8(static_cast<std::uint8_t>(state))
      .i16(m.half_period_us)
      .i16(m.throttle)
      .u16(m.current_mA)
      .body;
}
Body write(const BatteryData& m) { return BodyWriter('B').u8(m.seq).u16(m.voltage_mV).body; }
Body write(const ClockRate& m) { return BodyWriter('T').u8(m.id).u8(m.rate).body; }
Body write(const BoardText& m) { return BodyWriter(static_cast<char>(m.severity)).text(m.text).body; }

std::string printable(std::uint8_t letter) {
  if (letter >= 0x20 && letter < 0x7f) return std::string("'") + static_cast<char>(letter) + "'";
  return "byte " + std::to_string(letter);
}

Failure unknown(std::uint8_t letter) {
  return bad_input("no message begins with " + printable(letter), "telekyb3 frame",
                   "Check that the device speaks telekyb3 and the baud rate is right");
}
Failure wrong_length(std::uint8_t letter, std::size_t size) {
  return bad_input("message " + printable(letter) + " cannot have " + std::to_string(size) + " bytes",
                   "telekyb3 frame", "Check the line for noise");
}
Failure wrong_id(std::uint8_t letter) {
  return bad_input("message " + printable(letter) + " names motor 0; motors count from 1", "telekyb3 frame",
                   "Check the line for noise");
}

bool read_counts(BodyReader& r, Counts& counts) {
  if (r.left() == 0 || r.left() % 2 != 0) return false;
  counts.size = r.left() / 2;
  for (std::size_t i = 0; i < counts.size; ++i) counts.values[i] = r.i16();
  return true;
}

}  // namespace

std::string gains_text(const PidGains& m) {
  return "gains " + std::to_string(m.id) + ": " + std::to_string(m.kp) + " " + std::to_string(m.ki) + " " +
         std::to_string(m.kd) + " " + std::to_string(m.f);
}

Body encode(const HostMessage& message) {
  return std::visit([](const auto& m) { return write(m); }, message);
}
Body encode(const BoardMessage& message) {
  return std::visit([](const auto& m) { return write(m); }, message);
}

Result<HostMessage> decode_host(const Body& body) {
  if (body.size == 0) return bad_input("empty body", "telekyb3 frame", "Check the line for noise");
  const std::uint8_t letter = body.data[0];
  const auto length = [&] { return wrong_length(letter, body.size); };
  BodyReader r(body);
  switch (letter) {
    case '?':
      if (r.left() != 0) return length();
      return IdQuery{};
    case 'b':
    case 'm':
    case 'i':
    case 'c':
    case 't':
      if (r.left() != 4) return length();
      return StreamRequest{static_cast<StreamRequest::Stream>(letter), r.u32()};
    case 'g': {
      if (r.left() != 1) return length();
      const StartMotor m{r.u8()};
      if (m.id == 0) return wrong_id(letter);
      return m;
    }
    case 'x': {
      if (r.left() == 0) return StopMotors{};
      if (r.left() != 1) return length();
      const StopMotors m{r.u8()};
      if (*m.id == 0) return wrong_id(letter);
      return m;
    }
    case 'w': {
      VelocityCommand m;
      if (!read_counts(r, m.half_period_us)) return length();
      return m;
    }
    case 'q': {
      ThrottleCommand m;
      if (!read_counts(r, m.throttle)) return length();
      return m;
    }
    case '%': {
      if (r.left() != 9) return length();
      PidGains m;
      m.id = r.u8();
      m.kp = r.u16();
      m.ki = r.u16();
      m.kd = r.u16();
      m.f = r.u16();
      if (m.id == 0) return wrong_id(letter);
      return m;
    }
    case '~':
      if (r.left() != 2) return length();
      return Beep{r.u16()};
    default:
      return unknown(letter);
  }
}

Result<BoardMessage> decode_board(const Body& body) {
  if (body.size == 0) return bad_input("empty body", "telekyb3 frame", "Check the line for noise");
  const std::uint8_t letter = body.data[0];
  const auto length = [&] { return wrong_length(letter, body.size); };
  BodyReader r(body);
  switch (letter) {
    case '?':
      return IdReply{r.text()};
    case 'I': {
      if (body.size != 14) return length();
      ImuData m;
      m.seq = r.u8();
      for (auto& v : m.acceleration) v = r.i16();
      for (auto& v : m.gyro) v = r.i16();
      return m;
    }
    case 'C': {
      if (body.size != 8) return length();
      MagData m;
      m.seq = r.u8();
      for (auto& v : m.field) v = r.i16();
      return m;
    }
    case 'M': {
      if (body.size != 9) return length();
      MotorData m;
      m.seq = r.u8();
      const std::uint8_t state = r.u8();
      m.id = state & kIdMask;
      if (m.id == 0) return wrong_id(letter);
      m.emergency = (state & kEmergency) != 0;
      m.spinning = (state & kSpinning) != 0;
      m.starting = (state & kStarting) != 0;
      m.half_period_us = r.i16();
      m.throttle = r.i16();
      m.current_mA = r.u16();
      return m;
    }
    case 'B': {
      if (body.size != 4) return length();
      BatteryData m;
      m.seq = r.u8();
      m.voltage_mV = r.u16();
      return m;
    }
    case 'T': {
      if (body.size != 3) return length();
      ClockRate m;
      m.id = r.u8();
      m.rate = r.u8();
      if (m.id == 0) return wrong_id(letter);
      return m;
    }
    case 'N':
    case 'A':
    case 'E':
      return BoardText{static_cast<BoardText::Severity>(letter), r.text()};
    default:
      return unknown(letter);
  }
}

}  // namespace omniflight::gateway
