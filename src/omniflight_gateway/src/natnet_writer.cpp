// What a NatNet server sends, for the emulator.
#include "natnet_bytes.hpp"
#include "omniflight_gateway/natnet_packet.hpp"

namespace omniflight::gateway {
namespace {

void begin(std::vector<std::byte>& out, NatNetMessage message) {
  out.clear();
  natnet_put(out, static_cast<std::uint16_t>(message));
  natnet_put(out, std::uint16_t{0});
}
void end(std::vector<std::byte>& out) {
  const auto length = static_cast<std::uint16_t>(out.size() - 4);
  std::memcpy(out.data() + 2, &length, sizeof length);
}
void put(std::vector<std::byte>& out, std::int32_t value) { natnet_put(out, value); }
void put(std::vector<std::byte>& out, double value) { natnet_put(out, static_cast<float>(value)); }

/// A section without items.
void nothing(std::vector<std::byte>& out, const NatNetVersion& version) {
  put(out, 0);
  if (version >= k41) put(out, 0);
}

void write_body(std::vector<std::byte>& out, const NatNetBody& body, const NatNetVersion& version) {
  put(out, body.id);
  for (int k = 0; k < 3; ++k) put(out, body.position[k]);
  for (int k = 0; k < 4; ++k) put(out, body.attitude.coeffs()[k]);  // x y z w
  if (version < k30) put(out, 0);
  put(out, body.marker_error);
  natnet_put(out, static_cast<std::int16_t>(body.tracked ? 1 : 0));
}

}  // namespace

void write_natnet_frame(const NatNetFrame& frame, const NatNetVersion& version, std::vector<std::byte>& out) {
  begin(out, NatNetMessage::frame);
  put(out, frame.number);
  nothing(out, version);  // marker sets
  nothing(out, version);  // unlabeled markers
  put(out, static_cast<std::int32_t>(frame.bodies.size()));
  const std::size_t length = out.size();
  if (version >= k41) put(out, 0);
  const std::size_t first = out.size();
  for (const NatNetBody& body : frame.bodies) write_body(out, body, version);
  if (version >= k41) {
    const auto bytes = static_cast<std::int32_t>(out.size() - first);
    std::memcpy(out.data() + length, &bytes, sizeof bytes);
  }
  nothing(out, version);                       // skeletons
  if (version >= k41) nothing(out, version);   // assets
  nothing(out, version);                       // labeled markers
  if (version >= k29) nothing(out, version);   // force plates
  if (version >= k211) nothing(out, version);  // devices
  if (version < k30) put(out, frame.software_latency_s);
  put(out, 0);  // timecode
  put(out, 0);
  natnet_put(out, frame.timestamp_s);
  if (version >= k30)
    for (const std::uint64_t ticks : {frame.exposed, frame.received, frame.sent}) natnet_put(out, ticks);
  if (version >= k41) {
    put(out, 0);
    put(out, 0);
  }
  natnet_put(out, static_cast<std::int16_t>(frame.models_changed ? 2 : 0));
  put(out, 0);  // end of data
  end(out);
}

void write_natnet_models(const NatNetModels& models, const NatNetVersion& version,
                         std::vector<std::byte>& out) {
  begin(out, NatNetMessage::models);
  put(out, static_cast<std::int32_t>(models.size()));
  for (const auto& [id, name] : models) {
    put(out, 1);  // a rigid body
    const std::size_t length = out.size();
    if (version >= k41) put(out, 0);
    const std::size_t first = out.size();
    natnet_put(out, name);
    put(out, id);
    put(out, -1);  // no parent
    for (int k = 0; k < 3; ++k) put(out, 0.0);
    if (version >= k42)
      for (const double v : {0.0, 0.0, 0.0, 1.0}) put(out, v);
    if (version >= k30) {
      put(out, 1);
      for (int k = 0; k < 3; ++k) put(out, 0.0);
      put(out, 0);
      if (version >= k40) natnet_put(out, std::string("1"));
    }
    if (version >= k41) {
      const auto bytes = static_cast<std::int32_t>(out.size() - first);
      std::memcpy(out.data() + length, &bytes, sizeof bytes);
    }
  }
  end(out);
}

void write_natnet_server(const NatNetServer& server, std::vector<std::byte>& out) {
  constexpr std::size_t kName = 256;
  begin(out, NatNetMessage::server_info);
  const std::size_t first = out.size();
  natnet_put(out, server.name.substr(0, kName - 1));
  out.resize(first + kName);
  for (const int v : {3, 0, 0, 0}) natnet_put(out, static_cast<std::uint8_t>(v));
  for (const int v : {server.version.major, server.version.minor, 0, 0})
    natnet_put(out, static_cast<std::uint8_t>(v));
  if (server.version >= k30) natnet_put(out, server.clock_hz);
  end(out);
}

void write_natnet_request(NatNetMessage message, std::vector<std::byte>& out) {
  begin(out, message);
  end(out);
}

}  // namespace omniflight::gateway
