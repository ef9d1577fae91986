#include "omniflight_msgs/message_type.hpp"

namespace omniflight::msgs {

const MessageType* find_message_type(std::string_view ros_name) {
  for (const MessageType& type : message_types()) {
    if (type.ros_name == ros_name) return &type;
  }
  return nullptr;
}

}  // namespace omniflight::msgs
