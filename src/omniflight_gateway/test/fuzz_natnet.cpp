// Datagrams of unknown origin on the motion capture's port, read as each version. The first byte says which.
#include "mutated_inputs.hpp"
#include "omniflight_gateway/natnet_packet.hpp"

using namespace omniflight;
using namespace omniflight::gateway;

namespace {
const NatNetVersion kVersions[] = {{2, 7}, {2, 9}, {2, 11}, {3, 0}, {3, 1}, {4, 0}, {4, 1}, {4, 2}};

std::string seed(std::size_t version, const std::vector<std::byte>& packet) {
  std::string out(1, static_cast<char>(version));
  out.append(reinterpret_cast<const char*>(packet.data()), packet.size());
  return out;
}
}  // namespace

std::vector<std::string> seeds() {
  std::vector<std::string> out;
  NatNetFrame frame;
  frame.number = 7;
  for (int id = 1; id <= 3; ++id) {
    frame.bodies.emplace_back();
    frame.bodies.back().id = id;
  }
  std::vector<std::byte> packet;
  for (std::size_t v = 0; v < std::size(kVersions); ++v) {
    write_natnet_frame(frame, kVersions[v], packet);
    out.push_back(seed(v, packet));
    write_natnet_models({{1, "OmniMorph"}, {2, "frame"}}, kVersions[v], packet);
    out.push_back(seed(v, packet));
  }
  write_natnet_server({"Motive", {3, 1}, 10'000'000}, packet);
  out.push_back(seed(0, packet));
  return out;
}

void feed(std::string_view input) {
  if (input.empty()) return;
  const NatNetVersion& version = kVersions[static_cast<unsigned char>(input.front()) % std::size(kVersions)];
  const auto bytes = std::as_bytes(std::span(input.substr(1)));
  const auto message = natnet_message(bytes);
  if (!message) return;
  NatNetFrame frame;
  if (*message == NatNetMessage::frame) (void)parse_natnet_frame(bytes, version, frame);
  if (*message == NatNetMessage::models) (void)parse_natnet_models(bytes, version);
  if (*message == NatNetMessage::server_info) (void)parse_natnet_server(bytes);
}
