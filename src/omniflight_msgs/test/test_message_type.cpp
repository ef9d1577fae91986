#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "dds/dds.h"
#include "omniflight_msgs/types.hpp"

namespace omniflight::msgs {
namespace {

// Hashes of the interface packages of ROS 2, as `ros2 topic info --verbose` shows them.
const std::vector<std::pair<std::string, std::string>> kPublishedHashes = {
    {"std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
    {"std_msgs/msg/Header", "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"},
    {"geometry_msgs/msg/PoseStamped", "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"},
    {"geometry_msgs/msg/TwistStamped", "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"},
    {"geometry_msgs/msg/AccelStamped", "ef1df9eabae0a708cc049a061ebcddc4e2a5f745730100ba680e086a9698b165"},
    {"geometry_msgs/msg/WrenchStamped", "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"},
    {"geometry_msgs/msg/TransformStamped",
     "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206"},
    {"tf2_msgs/msg/TFMessage", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
    {"rmw_dds_common/msg/ParticipantEntitiesInfo",
     "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"},
    {"nav_msgs/msg/Odometry", "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
    {"sensor_msgs/msg/Imu", "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"},
    {"sensor_msgs/msg/BatteryState", "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741"},
    {"trajectory_msgs/msg/MultiDOFJointTrajectory",
     "3a18fd095292a65cfde8833c72985a30af981f3ec44494655c6267262b443a4a"},
    {"diagnostic_msgs/msg/DiagnosticArray",
     "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
};

TEST(MessageType, HashesAreThoseOfRos2) {
  for (const auto& [name, hash] : kPublishedHashes) {
    const MessageType* type = find_message_type(name);
    ASSERT_NE(type, nullptr) << name;
    EXPECT_EQ(type->type_hash, "RIHS01_" + hash) << name;
  }
}

TEST(MessageType, DescriptorCarriesTheNameRos2Expects) {
  for (const MessageType& type : message_types()) {
    EXPECT_EQ(type.dds_name, type.descriptor->m_typename);
    EXPECT_EQ(type.size, type.descriptor->m_size);
    EXPECT_EQ(type.descriptor->m_nkeys, 0u) << type.ros_name << ": ROS 2 topics have no key";
  }
}

TEST(MessageType, TypeSupportGivesTheEntryOfTheType) {
  EXPECT_EQ(TypeSupport<geometry_msgs::PoseStamped>::type().ros_name, "geometry_msgs/msg/PoseStamped");
  EXPECT_EQ(TypeSupport<omniflight_msgs::Tick>::type().size, sizeof(omniflight_msgs::Tick));
  EXPECT_EQ(TypeSupport<actuator_msgs::Actuators>::type().dds_name, "actuator_msgs::msg::dds_::Actuators_");
}

TEST(MessageType, SchemaHoldsEveryReferredTypeOnce) {
  const std::string schema(find_message_type("geometry_msgs/msg/PoseStamped")->schema);
  const std::string separator(80, '=');
  for (const char* name : {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Pose",
                           "geometry_msgs/Point", "geometry_msgs/Quaternion"}) {
    const std::string head = separator + "\nMSG: " + name + "\n";
    const auto first = schema.find(head);
    EXPECT_NE(first, std::string::npos) << name;
    EXPECT_EQ(schema.find(head, first + 1), std::string::npos) << name;
  }
  EXPECT_EQ(schema.find("MSG: geometry_msgs/PoseStamped"), std::string::npos);
}

TEST(MessageType, UnknownNameIsNull) { EXPECT_EQ(find_message_type("geometry_msgs/msg/Nothing"), nullptr); }

}  // namespace
}  // namespace omniflight::msgs
