// What is known of every message type: names, schema text, hash and descriptor. Includes no header of the
// middleware.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

struct dds_topic_descriptor;

namespace omniflight::msgs {

/// One type of the bus. All text lives as long as the program.
struct MessageType {
  std::string_view ros_name;               ///< "geometry_msgs/msg/PoseStamped"
  std::string_view dds_name;               ///< "geometry_msgs::msg::dds_::PoseStamped_"
  std::string_view schema;                 ///< encoding "ros2msg": the text, then all referred types
  std::string_view type_hash;              ///< "RIHS01_" and 64 hexadecimal digits
  const dds_topic_descriptor* descriptor;  ///< how the middleware writes it as CDR
  std::size_t size;                        ///< sizeof of the C type [bytes]
};

/// Every type, each after the types it contains.
std::span<const MessageType> message_types();

/// By ROS name ("geometry_msgs/msg/PoseStamped"); null when unknown.
const MessageType* find_message_type(std::string_view ros_name);

/// TypeSupport<geometry_msgs::PoseStamped>::type() is the entry of that C type. Specialised in types.hpp.
template <class T>
struct TypeSupport;

}  // namespace omniflight::msgs
