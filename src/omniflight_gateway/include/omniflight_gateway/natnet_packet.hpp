// NatNet (OptiTrack Motive) packets, after the public description of the bit stream in the NatNet SDK: frames
// of data, model definitions and server information, versions 2.7 to 4.x. Little endian.
//
// A packet has no checksum of its own. What can be refused is: what does not fill its declared length
// exactly, counts that the bytes cannot hold, numbers that are not finite, quaternions that are none, an end
// that is not marked. A flipped bit inside a coordinate is left to UDP's checksum and to the estimator's
// innovation test.
#pragma once

#include <cstdint>
#include <map>
#include <omniflight_core/frames.hpp>
#include <omniflight_core/result.hpp>
#include <span>
#include <string>
#include <vector>

namespace omniflight::gateway {

struct NatNetVersion {
  int major = 0, minor = 0;
  friend auto operator<=>(const NatNetVersion&, const NatNetVersion&) = default;
};
std::string to_string(const NatNetVersion& version);
inline constexpr NatNetVersion kOldestNatNet{2, 7}, kNewestNatNet{4, 99};

enum class NatNetMessage : std::uint16_t {
  connect = 0,
  server_info = 1,
  request_models = 4,
  models = 5,
  frame = 7,
};

struct NatNetBody {
  std::int32_t id = 0;
  Vec3 position = Vec3::Zero();      ///< in the unit and axes of the stream
  Quat attitude = Quat::Identity();  ///< likewise; unit to 1 %
  double marker_error = 0;           ///< mean, in the unit of the stream
  bool tracked = true;
};

struct NatNetFrame {
  std::int32_t number = 0;
  std::vector<NatNetBody> bodies;                     ///< those outside of skeletons and assets
  double timestamp_s = 0;                             ///< s of the server's software clock
  double software_latency_s = 0;                      ///< s, before 3.0; else 0
  std::uint64_t exposed = 0, received = 0, sent = 0;  ///< ticks of the server's clock, from 3.0 on
  bool models_changed = false;
};

struct NatNetServer {
  std::string name;
  NatNetVersion version;       ///< of the bit stream
  std::uint64_t clock_hz = 0;  ///< of ticks; 0 before 3.0
};

/// Names of rigid bodies by id.
using NatNetModels = std::map<std::int32_t, std::string>;

/// What kind of message a datagram holds; its header must tell its length.
Result<NatNetMessage> natnet_message(std::span<const std::byte> datagram);
/// Into `frame`, which keeps its memory. On an error it is as it was left half way.
Status parse_natnet_frame(std::span<const std::byte> datagram, const NatNetVersion& version,
                          NatNetFrame& frame);
Result<NatNetModels> parse_natnet_models(std::span<const std::byte> datagram, const NatNetVersion& version);
Result<NatNetServer> parse_natnet_server(std::span<const std::byte> datagram);

/// The packets of a server, for the emulator. `out` is overwritten.
void write_natnet_frame(const NatNetFrame& frame, const NatNetVersion& version, std::vector<std::byte>& out);
void write_natnet_models(const NatNetModels& models, const NatNetVersion& version,
                         std::vector<std::byte>& out);
void write_natnet_server(const NatNetServer& server, std::vector<std::byte>& out);
/// A packet without content: connect, request_models.
void write_natnet_request(NatNetMessage message, std::vector<std::byte>& out);

/// Which axis of the stream points up.
enum class UpAxis { y, z };
/// From the stream's unit and axes to metres in a world whose z is up. Y-up: x stays, the stream's -z becomes
/// y, its y becomes z; bodies are turned with the world, so that a body that was defined upright stays
/// upright.
NatNetBody to_world(const NatNetBody& body, UpAxis up, double metres_per_unit);
/// The inverse, for the emulator.
NatNetBody from_world(const NatNetBody& body, UpAxis up, double metres_per_unit);

}  // namespace omniflight::gateway
