#include "omniflight_planning/zones.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr double kBoxTolerance = 1e-9;  // m, of a box that ends at a face of voxels

/// The voxels of a part of the map, as the distance transform takes them.
struct Region {
  std::array<int, 3> first{}, size{};
  std::vector<std::uint8_t> closed;
  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z - first[2]) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(y - first[1])) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x - first[0]);
  }
  template <class Visit>
  void for_all(const Visit& visit) const {
    for (int z = first[2]; z < first[2] + size[2]; ++z)
      for (int y = first[1]; y < first[1] + size[1]; ++y)
        for (int x = first[0]; x < first[0] + size[0]; ++x) visit(x, y, z);
  }
};

/// As far as distances can change: all of the map where the vehicle must stay in a box.
Region region_of(const Zones& zones, const DistanceMap& map) {
  Region out;
  const auto& size = map.size();
  if (zones.keep_in) {
    out.size = size;
    return out;
  }
  std::array<int, 3> from = size, to{-1, -1, -1};
  for (const Primitive& p : zones.keep_out) {
    const auto [low, high] = p.box();
    const Vec3 reach = Vec3::Constant(map.max_distance() + 2.0 * map.resolution());
    const auto first = map.voxel_of(low - reach), last = map.voxel_of(high + reach);
    for (std::size_t k = 0; k < 3; ++k)
      from[k] = std::min(from[k], first[k]), to[k] = std::max(to[k], last[k]);
  }
  for (std::size_t k = 0; k < 3; ++k) out.first[k] = from[k], out.size[k] = to[k] - from[k] + 1;
  return out;
}

}  // namespace

Status DistanceMap::close(const Zones& zones, const Deadline& deadline) {
  if (!zones.keep_in && zones.keep_out.empty()) return {};
  Region region = region_of(zones, *this);
  region.closed.assign(static_cast<std::size_t>(region.size[0]) * static_cast<std::size_t>(region.size[1]) *
                           static_cast<std::size_t>(region.size[2]),
                       0);
  for (const Primitive& p : zones.keep_out) {
    if (deadline.passed()) return out_of_time(deadline, "closing the zones of the mission");
    for_touched(p, lower_, size_, resolution_,
                [&](int x, int y, int z) { region.closed[region.at(x, y, z)] = 1; });
  }
  if (zones.keep_in) {
    const auto& [low, high] = *zones.keep_in;
    const double half = 0.5 * resolution_ - kBoxTolerance;
    region.for_all([&](int x, int y, int z) {
      const Vec3 c = voxel_center(x, y, z);
      if ((c - low).minCoeff() < half || (high - c).minCoeff() < half) region.closed[region.at(x, y, z)] = 1;
    });
  }
  const double half_voxels = 2.0 * max_distance_ / resolution_;
  const auto squared = squared_distances_to_boxes(region.closed, region.size,
                                                  static_cast<float>(half_voxels * half_voxels), deadline);
  if (squared.empty()) return out_of_time(deadline, "computing the distances to the zones of the mission");
  region.for_all([&](int x, int y, int z) {
    const float near = rounded_down(squared[region.at(x, y, z)], resolution_);
    float& kept = field_[index(x, y, z)];
    kept = std::min(kept, near);
  });
  std::array<int, 3> last{};
  for (std::size_t k = 0; k < 3; ++k) last[k] = region.first[k] + region.size[k] - 1;
  blocks_.update(field_, resolution_, region.first, last);
  return {};
}

}  // namespace omniflight::planning
