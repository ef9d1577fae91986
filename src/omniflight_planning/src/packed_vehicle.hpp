// The parts and spheres of a vehicle, laid out for vector instructions.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "omniflight_planning/vehicle_spheres.hpp"

namespace omniflight::planning {

/// Lengths in voxels of a map, in single precision; `rounding` bounds what that costs anywhere in the map and
/// is part of every radius. Constant after construction.
struct PackedVehicle {
  static constexpr int kLanes = 8;
  static constexpr std::size_t kMostClusters = 64;
  using Lanes = std::array<float, kLanes>;

  struct alignas(32) Row {
    Lanes x{}, y{}, z{};  ///< body frame
    Lanes radius{};       ///< spheres that fill up a row have a large negative one
  };
  struct Part {
    vehicle::CollisionShape::Kind kind{};
    std::array<float, 3> center{};               ///< body frame
    std::array<std::array<float, 3>, 3> axes{};  ///< body frame; a cylinder's axis is the last one
    std::array<float, 3> size{};  ///< sphere: radius; cylinder: radius, half length; box: half edges
  };

  /// Parts that share a bounding sphere, its centre in one of them, and a ball about it that is solid.
  std::vector<Row> clusters;
  std::vector<Lanes> solid;         ///< radius of that ball; negative where a row is filled up
  std::vector<std::uint32_t> rows;  ///< spheres of cluster k: rows[k] to rows[k + 1]
  std::vector<Row> spheres;
  std::vector<std::uint16_t> part_of;  ///< of sphere kLanes * row + lane
  std::vector<Part> parts;
  std::uint64_t all_clusters = 0;  ///< a bit each
  float radius = 0.0f;             ///< about the body origin, holds everything
  float inscribed = 0.0f;          ///< about the body origin, solid; not positive: none
  float rounding = 0.0f;
  float per_metre = 0.0f;
  float tolerance = 0.0f;  ///< to which parts are measured
};

/// voxels: of the map along its longest axis.
PackedVehicle packed(const VehicleSpheres& vehicle, double resolution, int voxels);

}  // namespace omniflight::planning
