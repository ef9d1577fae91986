// The vehicle in its place for Foxglove's 3D panel: messages foxglove.FrameTransform and foxglove.SceneUpdate
// as JSON (github.com/foxglove/schemas). Frames: world, and body.
#pragma once

#include "omniflight_view/foxglove.hpp"
#include "omniflight_view/scene.hpp"

namespace omniflight::view {

/// Channels of what follows: topics /view/transform, /view/vehicle, /view/world and /view/plan; the last two
/// latched.
FoxgloveChannel transform_channel();
FoxgloveChannel vehicle_channel();
FoxgloveChannel world_channel();
FoxgloveChannel plan_channel();

/// Pose of the body; empty when it is not known. ns: time of the message [ns].
std::string transform_message(const Frame& frame, std::int64_t ns);
/// Arms and rotors, tilted as the frame says; colours tell how near a rotor is to its limit.
std::string vehicle_message(const vehicle::Vehicle& vehicle, const Frame& frame, std::int64_t ns);
std::string world_message(const std::vector<planning::Primitive>& solids, std::int64_t ns);
std::string plan_message(const std::vector<Vec3>& path, std::int64_t ns);

}  // namespace omniflight::view
