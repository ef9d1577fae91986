#include "omniflight_components/natnet_config.hpp"

#include <charconv>

#include "omniflight_bus/participant.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_gateway/udp_socket.hpp"

namespace omniflight::components {

Result<gateway::NatNetVersion> natnet_version(const std::string& text, const std::string& where) {
  gateway::NatNetVersion v;
  const char *begin = text.data(), *end = begin + text.size();
  const auto major = std::from_chars(begin, end, v.major);
  const bool dot = major.ec == std::errc() && major.ptr != end && *major.ptr == '.';
  const auto minor = dot ? std::from_chars(major.ptr + 1, end, v.minor) : major;
  if (!dot || minor.ec != std::errc() || minor.ptr != end || v < gateway::kOldestNatNet ||
      v > gateway::kNewestNatNet)
    return bad_input("'" + text + "' is no version from 2.7 to 4.x", where, "For instance \"3.1\", or auto");
  return v;
}

Result<NatNetConfig> load_natnet(const std::string& file) {
  auto yaml = files::YamlReader::load(file);
  if (!yaml) return Failure(yaml.error());
  NatNetConfig c;
  if (yaml->string("schema") != "omniflight.natnet/1") yaml->error_at("schema", "is not omniflight.natnet/1");
  const auto address = [&](const char* key, const std::string& otherwise) {
    const std::string text = yaml->string(key, otherwise);
    if (auto ok = gateway::udp_address(text, 0); !ok)
      yaml->error_at(key, ok.error().message, "For instance 192.168.1.2");
    return text;
  };
  c.server = address("server", c.server);
  c.interface = address("interface", c.interface);
  c.multicast = address("multicast", c.multicast);
  c.data_port = static_cast<int>(yaml->integer("data_port", 1, 65535, c.data_port));
  c.command_port = static_cast<int>(yaml->integer("command_port", 1, 65535, c.command_port));
  if (const std::string version = yaml->string("version", "auto"); version != "auto") {
    auto read = natnet_version(version, file);
    if (read)
      c.version = *read;
    else
      yaml->error_at("version", read.error().message, "For instance \"3.1\", or auto");
  }
  using Up = gateway::UpAxis;
  c.up = yaml->choice<Up>("up_axis", {{"y", Up::y}, {"z", Up::z}}, Up::y);
  c.metres_per_unit = yaml->choice<double>("unit", {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}}, 1.0);
  c.latency_s = yaml->number("latency_s", files::between(0, 0.5, "s"), 0.0);
  for (auto& item : yaml->children("bodies", 1, 64)) {
    NatNetConfig::Body body{item.string("name"), item.string("topic", topics::mocap), {}};
    if (item.has("id")) body.id = static_cast<std::int32_t>(item.integer("id", 0, 1'000'000));
    if (auto ok = bus::dds_topic_name(body.topic); item.ok() && !ok)
      item.error_at("topic", ok.error().message);
    for (const auto& other : c.bodies)
      if (other.name == body.name || other.topic == body.topic)
        item.error("name or topic is that of another body");
    c.bodies.push_back(std::move(body));
  }
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return c;
}

}  // namespace omniflight::components
