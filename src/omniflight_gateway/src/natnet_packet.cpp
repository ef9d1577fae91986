#include "omniflight_gateway/natnet_packet.hpp"

#include "natnet_bytes.hpp"

namespace omniflight::gateway {
namespace {

constexpr std::size_t kHeader = 4;
constexpr std::size_t kFloat = 4, kInt = 4, kVector = 12;
enum Dataset { kMarkerSet = 0, kRigidBody = 1, kSkeleton = 2 };

/// The payload of a message of this kind, whose header tells its length.
Result<std::span<const std::byte>> payload(std::span<const std::byte> datagram, NatNetMessage wanted) {
  const auto message = natnet_message(datagram);
  if (!message) return Failure(message.error());
  if (*message != wanted)
    return bad_input("is message " + std::to_string(static_cast<int>(*message)) + ", not " +
                         std::to_string(static_cast<int>(wanted)),
                     "NatNet packet");
  return datagram.subspan(kHeader);
}

/// From 4.1 on sections tell their size behind their count, so that they can be passed over.
bool pass_over(NatNetReader& in, const NatNetVersion& version, const char* field) {
  if (version < k41) return false;
  in.skip(in.size(field), field);
  return true;
}

void skip_markers(NatNetReader& in, const char* field) { in.skip(in.count(field, kVector) * kVector, field); }

NatNetBody read_body(NatNetReader& in, const NatNetVersion& version) {
  NatNetBody body;
  body.id = in.take<std::int32_t>("rigid body id");
  for (int k = 0; k < 3; ++k) body.position[k] = in.number("position");
  double q[4];  // x y z w
  for (double& v : q) v = in.number("attitude", 1.01);
  body.attitude = Quat(q[3], q[0], q[1], q[2]);
  if (version < k30) {
    const std::size_t markers = in.count("markers of a rigid body", kVector + kInt + kFloat);
    in.skip(markers * (kVector + kInt + kFloat), "markers of a rigid body");
  }
  body.marker_error = in.number("marker error", 1e9);
  body.tracked = (in.take<std::int16_t>("rigid body flags") & 1) != 0;
  // Motive sends zeros for a body that it does not see
  const double norm = body.attitude.norm();
  if (in.ok() && !(std::abs(norm - 1.0) < 0.01)) {
    if (body.tracked) in.fail_at("attitude", "is no unit quaternion");
    body.tracked = false;
  }
  return body;
}

void skip_skeletons(NatNetReader& in, const NatNetVersion& version) {
  const std::size_t n = in.count("skeletons", 2 * kInt);
  if (pass_over(in, version, "skeletons")) return;
  for (std::size_t k = 0; k < n && in.ok(); ++k) {
    in.take<std::int32_t>("skeleton id");
    const std::size_t bones = in.count("bones", kInt + 7 * kFloat);
    for (std::size_t b = 0; b < bones && in.ok(); ++b) read_body(in, version);
  }
}

/// Force plates and devices: id, channels, and each channel's samples.
void skip_channels(NatNetReader& in, const NatNetVersion& version, const char* field) {
  const std::size_t n = in.count(field, 2 * kInt);
  if (pass_over(in, version, field)) return;
  for (std::size_t k = 0; k < n && in.ok(); ++k) {
    in.take<std::int32_t>(field);
    const std::size_t channels = in.count(field, kInt);
    for (std::size_t c = 0; c < channels && in.ok(); ++c) in.skip(in.count(field, kFloat) * kFloat, field);
  }
}

void read_suffix(NatNetReader& in, const NatNetVersion& version, NatNetFrame& frame) {
  frame.software_latency_s = version < k30 ? in.number("software latency", 10.0) : 0.0;
  in.skip(2 * kInt, "timecode");
  frame.timestamp_s = in.take<double>("timestamp");
  if (!(std::abs(frame.timestamp_s) < 2e9)) in.fail_at("timestamp", "is no number of seconds");
  frame.exposed = frame.received = frame.sent = 0;
  if (version >= k30) {
    frame.exposed = in.take<std::uint64_t>("exposure");
    frame.received = in.take<std::uint64_t>("reception");
    frame.sent = in.take<std::uint64_t>("transmission");
  }
  if (version >= k41) in.skip(2 * kInt, "precision timestamp");
  frame.models_changed = (in.take<std::int16_t>("frame flags") & 2) != 0;
  if (in.take<std::int32_t>("end of data") != 0) in.fail_at("end of data", "is not marked");
  if (in.left() != 0) in.fail_at("end of data", "is followed by " + std::to_string(in.left()) + " bytes");
}

Status check_version(const NatNetVersion& version) {
  if (version >= kOldestNatNet && version <= kNewestNatNet) return {};
  return bad_input("version " + to_string(version) + " is not read", "NatNet",
                   "Choose a bit stream from " + to_string(kOldestNatNet) + " to 4.x in Motive");
}

/// Markers of a description: offsets and labels, and names from 4.0 on.
void skip_described_markers(NatNetReader& in, const NatNetVersion& version) {
  if (version < k30) return;
  const std::size_t n = in.count("markers of a description", kVector + kInt);
  in.skip(n * (kVector + kInt), "markers of a description");
  if (version >= k40)
    for (std::size_t k = 0; k < n && in.ok(); ++k) in.text("marker name");
}

std::pair<std::int32_t, std::string> read_description(NatNetReader& in, const NatNetVersion& version) {
  std::string name = in.text("rigid body name");
  const auto id = in.take<std::int32_t>("rigid body id");
  in.skip(kInt + kVector, "parent of a rigid body");
  if (version >= k42) in.skip(4 * kFloat, "rotation of a rigid body");
  skip_described_markers(in, version);
  return {id, std::move(name)};
}

}  // namespace

std::string to_string(const NatNetVersion& v) {
  return std::to_string(v.major) + "." + std::to_string(v.minor);
}

Result<NatNetMessage> natnet_message(std::span<const std::byte> datagram) {
  NatNetReader in(datagram, "NatNet packet");
  const auto message = in.take<std::uint16_t>("message");
  const auto length = in.take<std::uint16_t>("length");
  if (in.ok() && length != in.left())
    in.fail_at("length",
               "is " + std::to_string(length) + " bytes, but " + std::to_string(in.left()) + " came");
  if (!in.ok()) return Failure(in.status().error());
  return static_cast<NatNetMessage>(message);
}

Status parse_natnet_frame(std::span<const std::byte> datagram, const NatNetVersion& version,
                          NatNetFrame& frame) {
  if (auto ok = check_version(version); !ok) return ok;
  const auto bytes = payload(datagram, NatNetMessage::frame);
  if (!bytes) return Failure(bytes.error());
  NatNetReader in(*bytes, "NatNet frame");
  frame.number = in.take<std::int32_t>("frame number");
  const std::size_t sets = in.count("marker sets", 1 + kInt);
  if (!pass_over(in, version, "marker sets"))
    for (std::size_t k = 0; k < sets && in.ok(); ++k) {
      in.text("marker set");
      skip_markers(in, "markers of a set");
    }
  const std::size_t others = in.count("unlabeled markers", kVector);
  if (!pass_over(in, version, "unlabeled markers")) in.skip(others * kVector, "unlabeled markers");
  const std::size_t bodies = in.count("rigid bodies", kInt + 7 * kFloat + kFloat + 2);
  const std::size_t length = version >= k41 ? in.size("rigid bodies") : 0, begin = in.at();
  frame.bodies.clear();
  for (std::size_t k = 0; k < bodies && in.ok(); ++k) frame.bodies.push_back(read_body(in, version));
  if (version >= k41 && in.ok() && in.at() - begin != length)
    in.fail_at("rigid bodies", "do not fill the " + std::to_string(length) + " bytes of their section");
  skip_skeletons(in, version);
  if (version >= k41) {
    in.count("assets", 2 * kInt);
    pass_over(in, version, "assets");
  }
  const std::size_t labeled = in.count("labeled markers", kInt + 4 * kFloat + 2);
  if (!pass_over(in, version, "labeled markers"))
    in.skip(labeled * (kInt + 4 * kFloat + 2 + (version >= k30 ? kFloat : 0)), "labeled markers");
  if (version >= k29) skip_channels(in, version, "force plates");
  if (version >= k211) skip_channels(in, version, "devices");
  read_suffix(in, version, frame);
  return in.status();
}

Result<NatNetModels> parse_natnet_models(std::span<const std::byte> datagram, const NatNetVersion& version) {
  if (auto ok = check_version(version); !ok) return Failure(ok.error());
  const auto bytes = payload(datagram, NatNetMessage::models);
  if (!bytes) return Failure(bytes.error());
  NatNetReader in(*bytes, "NatNet model definitions");
  NatNetModels models;
  const std::size_t n = in.count("data sets", kInt);
  for (std::size_t k = 0; k < n && in.ok(); ++k) {
    const auto type = in.take<std::int32_t>("type of a data set");
    const std::size_t length = version >= k41 ? in.size("data set") : 0, begin = in.at();
    if (type == kMarkerSet) {
      in.text("marker set name");
      const std::size_t markers = in.count("markers of a set", 1);
      for (std::size_t m = 0; m < markers && in.ok(); ++m) in.text("marker name");
    } else if (type == kRigidBody) {
      models.insert(read_description(in, version));
    } else if (type == kSkeleton && version < k41) {
      in.text("skeleton name");
      in.take<std::int32_t>("skeleton id");
      const std::size_t bones = in.count("bones", kInt);
      for (std::size_t b = 0; b < bones && in.ok(); ++b) read_description(in, version);
    } else if (version < k41) {
      break;  // nothing tells how long it is; rigid bodies come before it
    } else {
      in.skip(length, "data set");
    }
    if (version >= k41 && in.ok() && in.at() - begin != length)
      in.fail_at("data set", "does not fill its " + std::to_string(length) + " bytes");
  }
  if (!in.ok()) return Failure(in.status().error());
  return models;
}

Result<NatNetServer> parse_natnet_server(std::span<const std::byte> datagram) {
  constexpr std::size_t kName = 256;
  const auto bytes = payload(datagram, NatNetMessage::server_info);
  if (!bytes) return Failure(bytes.error());
  NatNetReader in(*bytes, "NatNet server information");
  NatNetServer server;
  server.name = in.text("server name", kName);
  in.skip(kName - std::min(kName, in.at()), "server name");
  in.skip(4, "version of the server");
  server.version.major = in.take<std::uint8_t>("version");
  server.version.minor = in.take<std::uint8_t>("version");
  in.skip(2, "version");
  if (server.version >= k30) server.clock_hz = in.take<std::uint64_t>("clock frequency");
  if (in.ok() && server.version >= k30 && (server.clock_hz < 1000 || server.clock_hz > 100'000'000'000))
    in.fail_at("clock frequency", "is " + std::to_string(server.clock_hz) + " Hz");
  if (!in.ok()) return Failure(in.status().error());
  if (auto ok = check_version(server.version); !ok) return Failure(ok.error());
  return server;
}

NatNetBody to_world(const NatNetBody& body, UpAxis up, double metres_per_unit) {
  NatNetBody out = body;
  const auto turned = [](const Vec3& v) { return Vec3(v.x(), -v.z(), v.y()); };
  const Vec3 v = body.attitude.vec();
  const Vec3 p = up == UpAxis::y ? turned(body.position) : body.position;
  const Vec3 u = up == UpAxis::y ? turned(v) : v;
  out.position = metres_per_unit * p;
  out.attitude = Quat(body.attitude.w(), u.x(), u.y(), u.z());
  return out;
}

NatNetBody from_world(const NatNetBody& body, UpAxis up, double metres_per_unit) {
  NatNetBody out = body;
  const auto turned = [](const Vec3& v) { return Vec3(v.x(), v.z(), -v.y()); };
  const Vec3 v = body.attitude.vec();
  const Vec3 p = up == UpAxis::y ? turned(body.position) : body.position;
  const Vec3 u = up == UpAxis::y ? turned(v) : v;
  out.position = p / metres_per_unit;
  out.attitude = Quat(body.attitude.w(), u.x(), u.y(), u.z());
  return out;
}

}  // namespace omniflight::gateway
