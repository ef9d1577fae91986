// Initial shapes of chains: unit directions of the links from the vehicle's end on, in world axes.
#pragma once

#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_proof/world.hpp"

namespace omniflight::proof {

/// Hangs in a zigzag of Cable::initial_bend and lies on the floor from where it reaches it.
Result<std::vector<Vec3>> hanging(const Cable& cable, const Vec3& attachment_W, double floor_z);
/// Down from the vehicle as far as the length allows, and up to the anchor: nearly at rest.
Result<std::vector<Vec3>> bulging(const OverheadRope& rope, const Vec3& attachment_W);

/// Attitudes of ball joints, one after the other, so that links along their -z have these directions.
std::vector<Quat> joint_attitudes(const std::vector<Vec3>& directions, const Quat& q_WB);

/// Links a rope is made of: an even number, so that both halves are alike.
inline int even_links(const OverheadRope& rope) { return rope.links + rope.links % 2; }

}  // namespace omniflight::proof
