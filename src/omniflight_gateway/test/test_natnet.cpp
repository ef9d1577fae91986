// NatNet packets as the public description lays them out, built here apart from the writer: read, cut at
// every byte, and with every bit flipped. All packets are synthetic.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

#include "omniflight_core/random.hpp"
#include "omniflight_gateway/natnet_packet.hpp"

namespace omniflight::gateway {
namespace {

const NatNetVersion k30{3, 0};
const NatNetVersion kVersions[] = {{2, 7}, {2, 9}, {2, 11}, {3, 0}, {3, 1}, {4, 0}, {4, 1}, {4, 2}};

/// Appends little-endian values as the description names them.
struct Builder {
  NatNetVersion v;
  std::vector<std::byte> bytes{4};

  bool since(int major, int minor) const { return v >= NatNetVersion{major, minor}; }
  template <class T>
  void add(T value) {
    std::byte raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.insert(bytes.end(), raw, raw + sizeof(T));
  }
  void i(int value) { add<std::int32_t>(value); }
  void f(double value) { add<float>(static_cast<float>(value)); }
  void s(int value) { add<std::int16_t>(static_cast<std::int16_t>(value)); }
  void text(const char* value) {
    for (; *value != '\0'; ++value) add<char>(*value);
    add<char>('\0');
  }
  /// A count and, from 4.1 on, the size of what `fill` appends.
  void section(int count, const std::function<void()>& fill) {
    i(count);
    const std::size_t at = bytes.size();
    if (since(4, 1)) i(0);
    const std::size_t first = bytes.size();
    fill();
    if (since(4, 1)) {
      const auto size = static_cast<std::int32_t>(bytes.size() - first);
      std::memcpy(bytes.data() + at, &size, 4);
    }
  }
  void body(int id, const Vec3& p, const Quat& q, bool tracked) {
    i(id);
    for (int k = 0; k < 3; ++k) f(p[k]);
    f(q.x()), f(q.y()), f(q.z()), f(q.w());
    if (!since(3, 0)) {
      i(3);
      for (int k = 0; k < 9; ++k) f(0.1 * k);
      for (int k = 0; k < 3; ++k) i(k);
      for (int k = 0; k < 3; ++k) f(0.014);
    }
    f(0.0004);
    s(tracked ? 1 : 0);
  }
  const std::vector<std::byte>& packet(NatNetMessage message) {
    const std::uint16_t header[2] = {static_cast<std::uint16_t>(message),
                                     static_cast<std::uint16_t>(bytes.size() - 4)};
    std::memcpy(bytes.data(), header, 4);
    return bytes;
  }
};

const Vec3 kPosition(1.25, 0.5, -2.0);
const Quat kAttitude = exp_rotation(Vec3(0.1, -0.4, 0.3));

/// A frame with something in every section: two bodies of which one is not seen.
std::vector<std::byte> full_frame(const NatNetVersion& v) {
  Builder b{v};
  b.i(4711);
  b.section(2, [&] {
    b.text("all");
    b.i(2);
    for (int k = 0; k < 6; ++k) b.f(k);
    b.text("OmniMorph");
    b.i(0);
  });
  b.section(1, [&] { b.f(1), b.f(2), b.f(3); });
  b.section(2, [&] {
    b.body(7, kPosition, kAttitude, true);
    b.body(9, Vec3::Zero(), Quat(0, 0, 0, 0), false);
  });
  b.section(1, [&] {
    b.i(1);
    b.i(1);
    b.body(3, Vec3(1, 1, 1), Quat::Identity(), true);
  });
  if (b.since(4, 1)) b.section(1, [&] { b.i(5), b.i(0), b.i(0); });
  b.section(1, [&] {
    b.i(65537);
    for (int k = 0; k < 4; ++k) b.f(0.1);
    b.s(2);
    if (b.since(3, 0)) b.f(0.0002);
  });
  const auto channels = [&] { b.section(1, [&] { b.i(1), b.i(2), b.i(1), b.f(9.81), b.i(0); }); };
  if (b.since(2, 9)) channels();
  if (b.since(2, 11)) channels();
  if (!b.since(3, 0)) b.f(0.0065);
  b.i(0), b.i(0);
  b.add<double>(123.456);
  if (b.since(3, 0))
    for (const std::uint64_t ticks : {1'000'000'000ull, 1'000'040'000ull, 1'000'065'000ull}) b.add(ticks);
  if (b.since(4, 1)) b.i(0), b.i(0);
  b.s(2);
  b.i(0);
  return b.packet(NatNetMessage::frame);
}

TEST(NatNet, EveryVersionIsReadWithAllItsSections) {
  for (const NatNetVersion& v : kVersions) {
    NatNetFrame frame;
    const auto ok = parse_natnet_frame(full_frame(v), v, frame);
    ASSERT_TRUE(ok) << to_string(v) << ": " << ok.error().text();
    EXPECT_EQ(frame.number, 4711);
    ASSERT_EQ(frame.bodies.size(), 2u) << "bones of skeletons are none";
    EXPECT_EQ(frame.bodies[0].id, 7);
    EXPECT_LT((frame.bodies[0].position - kPosition).norm(), 1e-6);
    EXPECT_LT(frame.bodies[0].attitude.angularDistance(kAttitude), 1e-6);
    EXPECT_TRUE(frame.bodies[0].tracked);
    EXPECT_FALSE(frame.bodies[1].tracked);
    EXPECT_NEAR(frame.timestamp_s, 123.456, 1e-9);
    EXPECT_TRUE(frame.models_changed);
    EXPECT_NEAR(frame.software_latency_s, v < k30 ? 0.0065 : 0.0, 1e-7);
    EXPECT_EQ(frame.sent, v < k30 ? 0u : 1'000'065'000u);
  }
}

TEST(NatNet, AFrameCutAtAnyByteIsRefusedAndNamesTheField) {
  int cuts = 0;
  for (const NatNetVersion& v : kVersions) {
    const auto whole = full_frame(v);
    NatNetFrame frame;
    for (std::size_t n = 0; n < whole.size(); ++n, ++cuts) {
      EXPECT_FALSE(parse_natnet_frame({whole.data(), n}, v, frame)) << to_string(v) << " at " << n;
      auto shorter = std::vector(whole.begin(),
                                 whole.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(n, 4)));
      const auto length =
          static_cast<std::uint16_t>(shorter.size() - 4);  // a header that agrees with the cut
      std::memcpy(shorter.data() + 2, &length, 2);
      const auto ok = parse_natnet_frame(shorter, v, frame);
      ASSERT_FALSE(ok) << to_string(v) << " at " << n;
      EXPECT_NE(ok.error().text().find("NatNet frame, byte"), std::string::npos) << ok.error().text();
    }
    auto longer = whole;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(parse_natnet_frame(longer, v, frame));
  }
  std::printf("%d cuts, all refused\n", cuts);
}

TEST(NatNet, FlippedBitsAreRefusedOrStayInsideANumberOrAName) {
  int flips = 0, refused = 0;
  for (const NatNetVersion& v : kVersions) {
    const auto whole = full_frame(v);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit, ++flips) {
      auto bent = whole;
      bent[bit / 8] ^= std::byte{static_cast<unsigned char>(1u << (bit % 8))};
      NatNetFrame frame;
      if (!parse_natnet_frame(bent, v, frame)) {
        ++refused;
        continue;
      }
      ASSERT_FALSE(bit < 32 || bit >= 8 * (whole.size() - 4)) << "header or end mark, bit " << bit;
      // what passes has the same shape: no body was lost, won, or is no pose
      ASSERT_EQ(frame.bodies.size(), 2u) << to_string(v) << " bit " << bit;
      for (const NatNetBody& b : frame.bodies) {
        EXPECT_TRUE(b.position.allFinite());
        EXPECT_TRUE(!b.tracked || std::abs(b.attitude.norm() - 1) < 0.011);
      }
    }
  }
  std::printf("%d flipped bits: %d refused, the rest inside a coordinate, a name or a time\n", flips,
              refused);
}

TEST(NatNet, RandomBytesNeverCrashNorAllocateMuch) {
  Random rng(11);
  for (int k = 0; k < 200000; ++k) {
    std::vector<std::byte> bytes(rng.next() % 400 + 4);
    for (std::byte& b : bytes) b = static_cast<std::byte>(rng.uniform() < 0.6 ? 0 : rng.next() & 0xff);
    const std::uint16_t header[2] = {static_cast<std::uint16_t>(k % 2 == 0 ? 7 : 5),
                                     static_cast<std::uint16_t>(bytes.size() - 4)};
    std::memcpy(bytes.data(), header, 4);
    NatNetFrame frame;
    const NatNetVersion v = kVersions[rng.next() % std::size(kVersions)];
    if (k % 2 == 0) {
      (void)parse_natnet_frame(bytes, v, frame);
      EXPECT_LE(frame.bodies.size(), 20u);
    } else {
      const auto models = parse_natnet_models(bytes, v);
      EXPECT_TRUE(!models || models->size() < 200);
    }
  }
}

TEST(NatNet, ModelDefinitionsNameTheBodies) {
  for (const NatNetVersion& v : kVersions) {
    Builder b{v};
    b.i(3);
    const auto data_set = [&](int type, const std::function<void()>& fill) {
      b.i(type);
      const std::size_t at = b.bytes.size();
      if (b.since(4, 1)) b.i(0);
      const std::size_t first = b.bytes.size();
      fill();
      if (!b.since(4, 1)) return;
      const auto size = static_cast<std::int32_t>(b.bytes.size() - first);
      std::memcpy(b.bytes.data() + at, &size, 4);
    };
    data_set(0, [&] { b.text("all"), b.i(1), b.text("m1"); });
    data_set(1, [&] {
      b.text("OmniMorph");
      b.i(7), b.i(-1), b.f(0), b.f(0), b.f(0);
      if (b.since(4, 2)) b.f(0), b.f(0), b.f(0), b.f(1);
      if (!b.since(3, 0)) return;
      b.i(2);
      for (int k = 0; k < 6; ++k) b.f(0.05);
      b.i(0), b.i(0);
      if (b.since(4, 0)) b.text("front"), b.text("back");
    });
    data_set(3, [&] { b.i(1), b.text("a force plate, of which nobody reads more"); });
    const auto packet = b.packet(NatNetMessage::models);
    const auto models = parse_natnet_models(packet, v);
    ASSERT_TRUE(models) << to_string(v) << ": " << models.error().text();
    EXPECT_EQ(*models, (NatNetModels{{7, "OmniMorph"}})) << to_string(v);
    for (std::size_t n = 4; n < packet.size() - 60; ++n) {
      auto cut = std::vector(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(n));
      const auto length = static_cast<std::uint16_t>(n - 4);
      std::memcpy(cut.data() + 2, &length, 2);
      EXPECT_FALSE(parse_natnet_models(cut, v)) << to_string(v) << " at " << n;
    }
  }
}

TEST(NatNet, WhatTheEmulatorWritesIsRead) {
  std::vector<std::byte> bytes;
  for (const NatNetVersion& v : kVersions) {
    NatNetFrame out;
    out.number = 5;
    out.bodies = {{.id = 2, .position = kPosition, .attitude = kAttitude}, {.id = 4, .tracked = false}};
    out.timestamp_s = 9.5;
    out.software_latency_s = v < k30 ? 0.004 : 0.0;
    if (v >= NatNetVersion{3, 0}) out.exposed = 100, out.received = 110, out.sent = 120;
    write_natnet_frame(out, v, bytes);
    NatNetFrame in;
    const auto ok = parse_natnet_frame(bytes, v, in);
    ASSERT_TRUE(ok) << to_string(v) << ": " << ok.error().text();
    ASSERT_EQ(in.bodies.size(), 2u);
    EXPECT_LT((in.bodies[0].position - kPosition).norm(), 1e-6);
    EXPECT_FALSE(in.bodies[1].tracked);
    EXPECT_EQ(in.exposed, out.exposed);
    write_natnet_models({{2, "a"}, {4, "b c"}}, v, bytes);
    const auto models = parse_natnet_models(bytes, v);
    ASSERT_TRUE(models) << models.error().text();
    EXPECT_EQ(models->at(4), "b c");
    write_natnet_server({.name = "Motive", .version = v, .clock_hz = 10'000'000}, bytes);
    const auto server = parse_natnet_server(bytes);
    ASSERT_TRUE(server) << server.error().text();
    EXPECT_EQ(server->version, v);
    EXPECT_EQ(server->clock_hz, v < k30 ? 0u : 10'000'000u);
    for (std::size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(parse_natnet_server({bytes.data(), n}));
  }
}

TEST(NatNet, AnotherVersionThanTheStreamsIsRefusedNotMisread) {
  NatNetFrame frame;
  for (const auto& [stream, read] : {std::pair<NatNetVersion, NatNetVersion>{{4, 1}, {3, 1}},
                                     {{3, 1}, {4, 1}},
                                     {{2, 7}, {3, 0}},
                                     {{3, 0}, {2, 9}}})
    EXPECT_FALSE(parse_natnet_frame(full_frame(stream), read, frame))
        << to_string(stream) << " as " << to_string(read);
  const auto old = parse_natnet_frame(full_frame({2, 7}), {2, 6}, frame);
  ASSERT_FALSE(old);
  EXPECT_NE(old.error().text().find("version 2.6 is not read"), std::string::npos);
}

TEST(NatNet, YUpBecomesZUpAndBack) {
  // a body upright in the stream, turned by yaw about the stream's y, is upright and turned by yaw about z
  const NatNetBody yawed{.id = 1, .position = Vec3(1, 2, -3), .attitude = exp_rotation(Vec3(0, 0.7, 0))};
  const NatNetBody world = to_world(yawed, UpAxis::y, 0.001);
  EXPECT_LT((world.position - Vec3(0.001, 0.003, 0.002)).norm(), 1e-12) << "mm";
  EXPECT_LT(world.attitude.angularDistance(exp_rotation(Vec3(0, 0, 0.7))), 1e-12);
  // frame invariance: the direction from one point of the body to another is turned like the body
  Random rng(3);
  const Mat3 turn = (Mat3() << 1, 0, 0, 0, 0, -1, 0, 1, 0).finished();
  for (int k = 0; k < 100; ++k) {
    const NatNetBody any{.id = 1,
                         .position = Vec3(rng.normal(), rng.normal(), rng.normal()),
                         .attitude = exp_rotation(Vec3(rng.normal(), rng.normal(), rng.normal()))};
    const NatNetBody w = to_world(any, UpAxis::y, 1.0);
    const Vec3 arm(rng.normal(), rng.normal(), rng.normal());
    EXPECT_LT((w.position + w.attitude * (turn * arm) - turn * (any.position + any.attitude * arm)).norm(),
              1e-12);
    const NatNetBody back = from_world(w, UpAxis::y, 1.0);
    EXPECT_LT((back.position - any.position).norm(), 1e-12);
    EXPECT_LT(back.attitude.angularDistance(any.attitude), 1e-7);
    EXPECT_LT((to_world(any, UpAxis::z, 1.0).position - any.position).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace omniflight::gateway
