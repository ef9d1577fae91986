// The telekyb3 wire: framing, every message there and back, noise.
#include <gtest/gtest.h>

#include <omniflight_core/random.hpp>
#include <string>
#include <vector>

#include "omniflight_gateway/tk3_codec.hpp"
#include "omniflight_gateway/tk3_units.hpp"

namespace omniflight::gateway {
namespace {

Body body_of(std::initializer_list<int> bytes) {
  Body b;
  for (const int v : bytes) b.push(static_cast<std::uint8_t>(v));
  return b;
}
std::vector<int> ints(std::span<const std::uint8_t> v) { return {v.begin(), v.end()}; }
/// Bodies that come out of these bytes.
std::vector<Body> decode_all(FrameDecoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<Body> out;
  for (const auto c : bytes) {
    if (decoder.push(c)) out.push_back(decoder.body());
  }
  return out;
}
std::span<const std::uint8_t> raw(const std::string& s) {
  return {reinterpret_cast<const std::uint8_t*>(s.data()), s.size()};
}
Body random_body(Random& random) {
  Body b;
  const auto n = 1 + random.next() % kMaxBody;
  while (b.size < n) b.push(static_cast<std::uint8_t>(random.next() >> 56));
  return b;
}

TEST(Frame, EscapesTheFourSpecialsWithTheirBitwiseNot) {
  const Wire wire = encode_frame(body_of({'w', '^', '$', '!', '\\', 0}));
  EXPECT_EQ(ints(wire.view()),
            (std::vector<int>{'^', 'w', '\\', 0xa1, '\\', 0xdb, '\\', 0xde, '\\', 0xa3, 0, '$'}));
}

TEST(Frame, AnyBodyComesBackAsItWas) {
  Random random(1, "bodies");
  FrameDecoder decoder;
  for (int i = 0; i < 20000; ++i) {
    const Body body = random_body(random);
    const auto out = decode_all(decoder, encode_frame(body).view());
    ASSERT_EQ(out.size(), 1u);
    ASSERT_EQ(ints(out[0].view()), ints(body.view()));
  }
  EXPECT_EQ(decoder.statistics().refused(), 0u);
}

TEST(Frame, LongestBodyFitsAndOneMoreByteIsRefused) {
  FrameDecoder decoder;
  EXPECT_EQ(decode_all(decoder, raw("^" + std::string(kMaxBody, 'a') + "$")).size(), 1u);
  EXPECT_EQ(decode_all(decoder, raw("^" + std::string(kMaxBody + 1, 'a') + "$^b$")).size(), 1u);
  EXPECT_EQ(decoder.statistics().too_long, 1u);
}

TEST(Frame, CountsEachKindOfRefusal) {
  FrameDecoder decoder;
  const auto out = decode_all(decoder, raw("zz^ab!c$^lost^\\q$^$^ok$"));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(std::string(out[0].view().begin(), out[0].view().end()), "ok");
  const auto& s = decoder.statistics();
  EXPECT_EQ(s.invalidated, 1u);
  EXPECT_EQ(s.restarted, 1u);
  EXPECT_EQ(s.bad_escape, 1u);
  EXPECT_EQ(s.empty, 1u);
  EXPECT_EQ(s.stray_bytes, 5u);  // zz, c$, $
  EXPECT_EQ(s.frames, 1u);
}

TEST(Noise, TenMegabytesOfGarbageLoseAtMostOneFrameAtEachResync) {
  Random random(2, "noise");
  FrameDecoder decoder;
  const Wire good = to_wire(HostMessage(StartMotor{3}));
  std::size_t bursts = 0, recovered = 0, false_frames = 0, decodable = 0;
  for (std::size_t noise = 0; noise < 10'000'000;) {
    const std::size_t n = 1 + random.next() % 4000;
    for (std::size_t i = 0; i < n; ++i) {
      if (!decoder.push(static_cast<std::uint8_t>(random.next() >> 56))) continue;
      ++false_frames;
      decodable += decode_board(decoder.body()).has_value() ? 1 : 0;
    }
    noise += n;
    ++bursts;
    // '^' always starts afresh: already the first intact frame after the noise must come through.
    for (const auto& body : decode_all(decoder, good.view())) {
      const auto m = decode_host(body);
      recovered += m && std::holds_alternative<StartMotor>(*m) && std::get<StartMotor>(*m).id == 3 ? 1 : 0;
    }
  }
  EXPECT_EQ(recovered, bursts);
  EXPECT_GT(decoder.statistics().refused(), 10000u);
  // Without a checksum noise does make frames; few of them mean anything.
  EXPECT_GT(false_frames, 0u);
  EXPECT_LT(static_cast<double>(decodable), 0.1 * static_cast<double>(false_frames));
  RecordProperty("false_frames_per_10MB", std::to_string(false_frames));
  RecordProperty("false_messages_per_10MB", std::to_string(decodable));
}

template <class Message>
void expect_round_trip_host(const Message& message, std::initializer_list<int> wire) {
  const Body body = encode(HostMessage(message));
  EXPECT_EQ(ints(body.view()), std::vector<int>(wire));
  const auto back = decode_host(body);
  ASSERT_TRUE(back) << back.error().text();
  ASSERT_TRUE(std::holds_alternative<Message>(*back));
  EXPECT_EQ(ints(encode(*back).view()), ints(body.view()));
}
template <class Message>
void expect_round_trip_board(const Message& message, std::initializer_list<int> wire) {
  const Body body = encode(BoardMessage(message));
  EXPECT_EQ(ints(body.view()), std::vector<int>(wire));
  const auto back = decode_board(body);
  ASSERT_TRUE(back) << back.error().text();
  ASSERT_TRUE(std::holds_alternative<Message>(*back));
  EXPECT_EQ(ints(encode(*back).view()), ints(body.view()));
}

TEST(Codec, HostMessagesHaveTheDocumentedBytes) {
  using Stream = StreamRequest::Stream;
  expect_round_trip_host(IdQuery{}, {'?'});
  expect_round_trip_host(StreamRequest{Stream::imu, 1000}, {'i', 0, 0, 3, 0xe8});
  expect_round_trip_host(StreamRequest{Stream::battery, 1000000}, {'b', 0, 0x0f, 0x42, 0x40});
  expect_round_trip_host(StreamRequest{Stream::motor, 0xfffefdfc}, {'m', 0xff, 0xfe, 0xfd, 0xfc});
  expect_round_trip_host(StreamRequest{Stream::magnetometer, 0}, {'c', 0, 0, 0, 0});
  expect_round_trip_host(StreamRequest{Stream::clock, 1}, {'t', 0, 0, 0, 1});
  expect_round_trip_host(StartMotor{4}, {'g', 4});
  expect_round_trip_host(StopMotors{}, {'x'});
  expect_round_trip_host(StopMotors{2}, {'x', 2});
  expect_round_trip_host(VelocityCommand{{{4166, -4166, 32767}, 3}},
                         {'w', 0x10, 0x46, 0xef, 0xba, 0x7f, 0xff});
  expect_round_trip_host(ThrottleCommand{{{1023, -1023}, 2}}, {'q', 3, 0xff, 0xfc, 1});
  expect_round_trip_host(PidGains{1, 1, 2, 3, 0x1234}, {'%', 1, 0, 1, 0, 2, 0, 3, 0x12, 0x34});
  expect_round_trip_host(Beep{440}, {'~', 1, 0xb8});
}

TEST(Codec, BoardMessagesHaveTheDocumentedBytes) {
  expect_round_trip_board(IdReply{"teensy1.2"}, {'?', 't', 'e', 'e', 'n', 's', 'y', '1', '.', '2'});
  expect_round_trip_board(ImuData{7, {1, -1, 4096}, {-32768, 32767, 0}},
                          {'I', 7, 0, 1, 0xff, 0xff, 0x10, 0, 0x80, 0, 0x7f, 0xff, 0, 0});
  expect_round_trip_board(MagData{9, {1, 2, -3}}, {'C', 9, 0, 1, 0, 2, 0xff, 0xfd});
  expect_round_trip_board(MotorData{1, 4, false, true, false, 4166, 512, 1500},
                          {'M', 1, 0x24, 0x10, 0x46, 2, 0, 5, 0xdc});
  expect_round_trip_board(MotorData{1, 15, true, false, true, -1, -1, 65535},
                          {'M', 1, 0x9f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff});
  expect_round_trip_board(BatteryData{2, 14800}, {'B', 2, 0x39, 0xd0});
  expect_round_trip_board(ClockRate{3, 200}, {'T', 3, 200});
  expect_round_trip_board(BoardText{BoardText::Severity::error, "hot"}, {'E', 'h', 'o', 't'});
  expect_round_trip_board(BoardText{BoardText::Severity::warning, ""}, {'A'});
  expect_round_trip_board(BoardText{BoardText::Severity::info, "n"}, {'N', 'n'});
}

TEST(Codec, TheLongestVelocityCommandFits) {
  VelocityCommand m;
  m.half_period_us.size = m.half_period_us.values.size();
  m.half_period_us.values.fill(0x5e24);  // '^' and '$': every byte escaped
  FrameDecoder decoder;
  const auto out = decode_all(decoder, to_wire(HostMessage(m)).view());
  ASSERT_EQ(out.size(), 1u);
  const auto back = decode_host(out[0]);
  ASSERT_TRUE(back);
  EXPECT_EQ(std::get<VelocityCommand>(*back).half_period_us.values, m.half_period_us.values);
}

TEST(Codec, WhateverDecodesEncodesToTheSameBytes) {
  Random random(3, "codec");
  std::size_t decoded = 0;
  for (int i = 0; i < 300000; ++i) {
    Body body = random_body(random);
    body.size = 1 + random.next() % 16;
    body.data[0] = static_cast<std::uint8_t>("?bmictgxwq%~ICMBTNAE"[random.next() % 20]);
    if (const auto m = decode_host(body)) {
      ++decoded;
      ASSERT_EQ(ints(encode(*m).view()), ints(body.view()));
    }
    if (body.data[0] == 'M') body.data[2] &= 0xbf;  // one state bit has no meaning
    if (const auto m = decode_board(body)) {
      ++decoded;
      ASSERT_EQ(ints(encode(*m).view()), ints(body.view()));
    }
  }
  EXPECT_GT(decoded, 20000u);
}

TEST(Codec, RefusesWrongLengthsUnknownLettersAndMotorZero) {
  const auto text = [](const auto& result) { return result ? std::string() : result.error().text(); };
  EXPECT_NE(text(decode_board(body_of({'I', 1, 2}))).find("'I' cannot have 3 bytes"), std::string::npos);
  EXPECT_NE(text(decode_board(body_of({'Z'}))).find("no message begins with 'Z'"), std::string::npos);
  EXPECT_NE(text(decode_board(body_of({7}))).find("byte 7"), std::string::npos);
  EXPECT_NE(text(decode_host(body_of({'g', 0}))).find("motor 0"), std::string::npos);
  EXPECT_NE(text(decode_board(body_of({'M', 0, 0x20, 0, 0, 0, 0, 0, 0}))).find("motor 0"), std::string::npos);
  EXPECT_FALSE(decode_host(body_of({'w'})));
  EXPECT_FALSE(decode_host(body_of({'w', 1, 2, 3})));
  EXPECT_FALSE(decode_host(body_of({'?', 1})));
  EXPECT_FALSE(decode_host(Body{}));
  EXPECT_FALSE(decode_board(Body{}));
}

TEST(Units, CountsSaturateInsteadOfWrapping) {
  EXPECT_EQ(to_lsb(1e9, 1e-3), 32767);
  EXPECT_EQ(to_lsb(-1e9, 1e-3), -32768);
  EXPECT_EQ(to_lsb(std::nan(""), 1e-3), 0);
  EXPECT_EQ(to_lsb(kGravity, chimera_imu_scale().acceleration), 4096);
}

}  // namespace
}  // namespace omniflight::gateway
