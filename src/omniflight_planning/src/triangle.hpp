// Triangles: whether one touches a box, and how far two are apart.
#pragma once

#include <array>

#include "omniflight_core/frames.hpp"

namespace omniflight::planning {

using Triangle = std::array<Vec3, 3>;  // m

/// Whether a triangle touches the axis-aligned box with this centre and these half edges [m]: separating axes
/// (Akenine-Moeller 2001), widened by what rounding may be. Never misses a contact; degenerate triangles are
/// the segment or the point that they are.
bool touches_box(const Triangle& t, const Vec3& center, const Vec3& half);

/// Distance [m] between two segments (Ericson, Real-Time Collision Detection, 5.1.9).
double segments_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

/// Distance [m] from a point to a triangle (Ericson, 5.1.5).
double point_triangle_distance(const Vec3& p, const Triangle& t);

/// Distance [m] between two triangles; 0 where they meet, which rounding of 1e-9 m may decide. The least of
/// the nine distances of edges and the six of corners, or 0 where an edge passes the inside of the other.
double triangles_distance(const Triangle& a, const Triangle& b);

}  // namespace omniflight::planning
