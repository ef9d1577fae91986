// Where a mission's vehicle may not be, beyond what the map has as occupied.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "omniflight_planning/map.hpp"
#include "omniflight_planning/test_bed.hpp"

namespace omniflight::planning {

/// Zones count as obstacles for vehicle and tether in plan, verification and the judgement of flights; what
/// is landed on is the map's alone.
struct Zones {
  UnknownSpace unknown = UnknownSpace::occupied;  ///< what voxels count as that the map says nothing about
  std::vector<Primitive> keep_out;                ///< every voxel that one touches is occupied
  std::optional<std::array<Vec3, 2>> keep_in;     ///< m, corners of the box that nothing may leave
};

/// The voxels of a grid that a primitive touches; visit(x, y, z).
template <class Visit>
void for_touched(const Primitive& primitive, const Vec3& lower, const std::array<int, 3>& size,
                 double resolution, const Visit& visit) {
  const auto [low, high] = primitive.box();
  std::array<int, 3> from{}, to{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto cell = [&](double at) {
      return std::clamp((at - lower[static_cast<int>(k)]) / resolution, -1.0, size[k] + 1.0);
    };
    from[k] = std::max(0, static_cast<int>(std::floor(cell(low[static_cast<int>(k)]) - 1e-6)));
    to[k] = std::min(size[k] - 1, static_cast<int>(std::floor(cell(high[static_cast<int>(k)]) + 1e-6)));
  }
  for (int z = from[2]; z <= to[2]; ++z)
    for (int y = from[1]; y <= to[1]; ++y)
      for (int x = from[0]; x <= to[0]; ++x) {
        const Vec3 center = lower + resolution * (Vec3(x, y, z) + Vec3::Constant(0.5));
        if (primitive.touches_cube(center, 0.5 * resolution)) visit(x, y, z);
      }
}

}  // namespace omniflight::planning
