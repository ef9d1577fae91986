// The messages of the test as ROS 2 defines them, written and read by Fast CDR: nothing of omniflight_msgs.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/exceptions/BadParamException.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace omniflight::bus::second_vendor {

using eprosima::fastcdr::Cdr;

constexpr const char* kEntitiesType = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
constexpr const char* kPoseType = "geometry_msgs::msg::dds_::PoseStamped_";

/// rmw_dds_common/msg/NodeEntitiesInfo
struct NodeEntities {
  std::string name_space, name;
  std::vector<std::vector<std::uint8_t>> readers, writers;
};
/// rmw_dds_common/msg/ParticipantEntitiesInfo with GIDs of this many bytes.
template <std::size_t bytes>
struct Entities {
  std::vector<std::uint8_t> gid;
  std::vector<NodeEntities> nodes;
};

inline std::uint32_t decode_length(Cdr& in) {
  std::uint32_t out = 0;
  in >> out;
  if (out > 10'000)
    throw eprosima::fastcdr::exception::BadParamException("a length that no message here has");
  return out;
}
inline std::vector<std::uint8_t> decode_gid(Cdr& in, std::size_t bytes) {
  std::vector<std::uint8_t> out(bytes);
  in.deserializeArray(out.data(), bytes);
  return out;
}
inline std::vector<std::vector<std::uint8_t>> decode_gids(Cdr& in, std::size_t bytes) {
  std::vector<std::vector<std::uint8_t>> out(decode_length(in));
  for (auto& gid : out) gid = decode_gid(in, bytes);
  return out;
}
template <std::size_t bytes>
void decode(Cdr& in, Entities<bytes>& out) {
  out.gid = decode_gid(in, bytes);
  out.nodes.assign(decode_length(in), {});
  for (NodeEntities& node : out.nodes) {
    in >> node.name_space >> node.name;
    node.readers = decode_gids(in, bytes);
    node.writers = decode_gids(in, bytes);
  }
}
template <std::size_t bytes>
void encode(Cdr&, const Entities<bytes>&) {
  throw eprosima::fastcdr::exception::BadParamException("only read here");
}

/// geometry_msgs/msg/PoseStamped
struct Pose {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame;
  std::array<double, 7> numbers{};  ///< position x y z [m], orientation x y z w
};
inline void decode(Cdr& in, Pose& out) {
  in >> out.sec >> out.nanosec >> out.frame;
  for (double& number : out.numbers) in >> number;
}
inline void encode(Cdr& out, const Pose& in) {
  out << in.sec << in.nanosec << in.frame;
  for (const double number : in.numbers) out << number;
}

}  // namespace omniflight::bus::second_vendor
