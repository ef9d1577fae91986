#include "topic_map.hpp"

namespace omniflight::recording {

const std::vector<TopicEntry>& topic_map() {
  static const std::vector<TopicEntry> table{
      {"/omniflight/imu",
       "sensor_msgs/Imu",
       {{"gyro", {"angular_velocity.x", "angular_velocity.y", "angular_velocity.z"}},
        {"acc", {"linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"}}}},
      {"/omniflight/mocap",
       "geometry_msgs/PoseStamped",
       {{"position", {"pose.position.x", "pose.position.y", "pose.position.z"}},
        {"attitude",
         {"pose.orientation.w", "pose.orientation.x", "pose.orientation.y", "pose.orientation.z"}}}},
      {"/omniflight/rotors",
       "omniflight_msgs/RotorTelemetry",
       {{"rotor_speed", {"velocity"}}, {"alpha", {"alpha"}}}},
      {"/omniflight/command",
       "actuator_msgs/Actuators",
       {{"rotor_command", {"velocity"}}, {"alpha_command", {"position"}}}},
      {"/omniflight/controller",
       "omniflight_msgs/ControllerState",
       {{"ref_position", {"ref_position"}},
        {"ref_attitude", {"ref_attitude"}},
        {"ref_velocity", {"ref_velocity"}},
        {"ref_angular_velocity", {"ref_angular_velocity"}},
        {"ref_acceleration", {"ref_acceleration"}},
        {"ref_angular_acceleration", {"ref_angular_acceleration"}},
        {"est_position", {"est_position"}},
        {"est_attitude", {"est_attitude"}},
        {"est_velocity", {"est_velocity"}},
        {"est_angular_velocity", {"est_angular_velocity"}},
        {"integral", {"integral"}},
        {"qddr", {"desired_acceleration"}}}},
      {"/omniflight/allocator",
       "omniflight_msgs/AllocatorState",
       {{"thrust_command", {"thrust"}}, {"qdd", {"achieved_acceleration"}}, {"alpha_command", {"alpha"}}}},
      {"/omniflight/battery", "sensor_msgs/BatteryState", {{"vbat", {"voltage"}}, {"ibat", {"current"}}}},
      {"/omniflight/truth",
       "omniflight_msgs/TruthState",
       {{"truth_position", {"position"}},
        {"truth_attitude", {"attitude"}},
        {"truth_velocity", {"velocity"}},
        {"truth_angular_velocity", {"angular_velocity"}},
        {"truth_rotor_speed", {"rotor_velocity"}},
        {"truth_alpha", {"alpha"}},
        {"truth_power", {"mechanical_power"}},
        {"truth_wrench", {"external_wrench"}}}},
      {"/omniflight/tick", "omniflight_msgs/Tick", {{"phase", {"phase"}}}},
  };
  return table;
}

}  // namespace omniflight::recording
