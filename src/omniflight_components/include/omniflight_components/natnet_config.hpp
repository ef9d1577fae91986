// Where the motion capture is, and which of its bodies are whose.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_gateway/natnet_packet.hpp"

namespace omniflight::components {

struct NatNetConfig {
  std::string server = "127.0.0.1";     ///< IPv4 address of the computer with Motive
  std::string interface = "127.0.0.1";  ///< IPv4 address of this computer in the same network
  std::string multicast = "239.255.42.99";
  int data_port = 1511, command_port = 1510;
  std::optional<gateway::NatNetVersion> version;  ///< of the bit stream; empty: the server is asked
  gateway::UpAxis up = gateway::UpAxis::y;
  double metres_per_unit = 1.0;
  double latency_s = 0.0;  ///< s from exposure to the stamp, where the stream does not tell (before 3.0)
  struct Body {
    std::string name;                ///< in Motive
    std::string topic;               ///< ROS name
    std::optional<std::int32_t> id;  ///< streaming id; empty: the server is asked by name
  };
  std::vector<Body> bodies;  ///< one at least
};

/// Schema omniflight.natnet/1; configs/natnet/optitrack.yaml has all keys.
Result<NatNetConfig> load_natnet(const std::string& file);
/// "3.1"; refuses what is not read.
Result<gateway::NatNetVersion> natnet_version(const std::string& text, const std::string& where);

}  // namespace omniflight::components
