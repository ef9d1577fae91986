// Names of the topics that components meet on (ROS names; on the wire they carry the prefix rt/).
#pragma once

namespace omniflight::components::topics {

inline constexpr const char* imu = "/omniflight/imu";      ///< sensor_msgs/Imu
inline constexpr const char* mocap = "/omniflight/mocap";  ///< geometry_msgs/PoseStamped
inline constexpr const char* emulated_mocap =
    "/omniflight/emulated_mocap";  ///< geometry_msgs/PoseStamped, from the emulated world to its NatNet
                                   ///< server
inline constexpr const char* rotors = "/omniflight/rotors";    ///< omniflight_msgs/RotorTelemetry
inline constexpr const char* battery = "/omniflight/battery";  ///< sensor_msgs/BatteryState
inline constexpr const char* tick = "/omniflight/tick";        ///< omniflight_msgs/Tick
inline constexpr const char* truth = "/omniflight/truth";  ///< omniflight_msgs/TruthState, simulation only
inline constexpr const char* controller = "/omniflight/controller";  ///< omniflight_msgs/ControllerState
inline constexpr const char* allocator = "/omniflight/allocator";    ///< omniflight_msgs/AllocatorState
inline constexpr const char* command = "/omniflight/command";        ///< actuator_msgs/Actuators
inline constexpr const char* recorder = "/omniflight/recorder";      ///< omniflight_msgs/RecorderState
inline constexpr const char* trajectory = "/command_trajectory";  ///< trajectory_msgs/MultiDOFJointTrajectory

/// diagnostic_msgs/DiagnosticArray of the allocator, latched: rotors that it leaves out
inline constexpr const char* lost_rotors = "/omniflight/lost_rotors";
inline constexpr const char* failsafe = "/omniflight/failsafe";  ///< diagnostic_msgs/DiagnosticArray, latched
inline constexpr const char* gate = "/omniflight/gate";          ///< diagnostic_msgs/DiagnosticArray, latched
inline constexpr const char* wish = "/omniflight/wish";          ///< std_msgs/String of the operator, latched

/// std_msgs/String, a mission (name or file) to fly from now on; the planner alone hears it. A second line
/// may name the request, see replanning_message.hpp
inline constexpr const char* mission = "/omniflight/mission";

/// diagnostic_msgs/DiagnosticArray of the planner, latched: what became of missions that came in flight
inline constexpr const char* replanning = "/omniflight/replanning";

inline constexpr const char* transforms = "/tf";        ///< tf2_msgs/TFMessage, map to base_link
inline constexpr const char* joints = "/joint_states";  ///< sensor_msgs/JointState, as commanded
inline constexpr const char* robot_description = "/robot_description";  ///< std_msgs/String, latched: URDF
inline constexpr const char* diagnostics =
    "/diagnostics";                                       ///< diagnostic_msgs/DiagnosticArray, as ROS has it
inline constexpr const char* state = "/component_state";  ///< omniflight_msgs/ComponentState, latched

/// A topic with its ROS type.
struct Entry {
  const char* topic;
  const char* type;
  bool latched;  ///< a late subscriber receives the last message of each publisher
};
/// Every topic of a flight that is worth recording; the tick is the first.
inline constexpr Entry recorded[] = {
    {tick, "omniflight_msgs/msg/Tick", false},
    {imu, "sensor_msgs/msg/Imu", false},
    {mocap, "geometry_msgs/msg/PoseStamped", false},
    {rotors, "omniflight_msgs/msg/RotorTelemetry", false},
    {battery, "sensor_msgs/msg/BatteryState", false},
    {controller, "omniflight_msgs/msg/ControllerState", false},
    {allocator, "omniflight_msgs/msg/AllocatorState", false},
    {command, "actuator_msgs/msg/Actuators", false},
    {truth, "omniflight_msgs/msg/TruthState", false},
    {trajectory, "trajectory_msgs/msg/MultiDOFJointTrajectory", true},
    {diagnostics, "diagnostic_msgs/msg/DiagnosticArray", false},
    {failsafe, "diagnostic_msgs/msg/DiagnosticArray", true},
    {lost_rotors, "diagnostic_msgs/msg/DiagnosticArray", true},
    {gate, "diagnostic_msgs/msg/DiagnosticArray", true},
    {wish, "std_msgs/msg/String", true},
    {mission, "std_msgs/msg/String", false},
    {replanning, "diagnostic_msgs/msg/DiagnosticArray", true},
    {state, "omniflight_msgs/msg/ComponentState", true},
};

}  // namespace omniflight::components::topics
