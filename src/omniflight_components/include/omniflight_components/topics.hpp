// Names of the topics that components meet on (ROS names; on the wire they carry the prefix rt/).
#pragma once

namespace omniflight::components::topics {

inline constexpr const char* imu = "/omniflight/imu";          ///< sensor_msgs/Imu
inline constexpr const char* mocap = "/omniflight/mocap";      ///< geometry_msgs/PoseStamped
inline constexpr const char* rotors = "/omniflight/rotors";    ///< omniflight_msgs/RotorTelemetry
inline constexpr const char* battery = "/omniflight/battery";  ///< sensor_msgs/BatteryState
inline constexpr const char* tick = "/omniflight/tick";        ///< omniflight_msgs/Tick
inline constexpr const char* truth = "/omniflight/truth";  ///< omniflight_msgs/TruthState, simulation only
inline constexpr const char* controller = "/omniflight/controller";  ///< omniflight_msgs/ControllerState
inline constexpr const char* allocator = "/omniflight/allocator";    ///< omniflight_msgs/AllocatorState
inline constexpr const char* command = "/omniflight/command";        ///< actuator_msgs/Actuators
inline constexpr const char* recorder = "/omniflight/recorder";      ///< omniflight_msgs/RecorderState
inline constexpr const char* trajectory = "/command_trajectory";  ///< trajectory_msgs/MultiDOFJointTrajectory

}  // namespace omniflight::components::topics
