#include "packed_vehicle.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

using Kind = vehicle::CollisionShape::Kind;

constexpr double kMeasuredTo = 1e-4;  // m
constexpr float kNothing = -1e30f;    // radius of what fills up a row
/// Of positions in single precision: six operations, each half a unit in the last place of the largest
/// number.
constexpr double kRoundingOfPosition = 1e-6;  // of the map's size and the vehicle's, voxels
constexpr double kLeastRounding = 1e-5;       // voxels

/// Radius [m] of the largest ball about the centre of a shape in it.
double solid_radius(const vehicle::CollisionShape& s) {
  switch (s.kind) {
    case Kind::sphere:
      return s.size.x();
    case Kind::cylinder:
      return std::min(s.size.x(), 0.5 * s.size.y());
    case Kind::box:
      return 0.5 * s.size.minCoeff();
  }
  return 0.0;
}

struct Cluster {
  BodySphere bound;
  double solid = 0.0;  // m
  std::vector<const SphereGroup*> groups;
};

/// A group whose bounding sphere lies in that of another joins it. Where there are too many, the rest is one.
std::vector<Cluster> clusters_of(const VehicleSpheres& vehicle) {
  std::vector<const SphereGroup*> groups;
  for (const SphereGroup& group : vehicle.groups) groups.push_back(&group);
  std::stable_sort(groups.begin(), groups.end(), [](const SphereGroup* a, const SphereGroup* b) {
    return a->bound.radius > b->bound.radius;
  });
  std::vector<Cluster> out;
  for (const SphereGroup* group : groups) {
    const double solid = solid_radius(group->part);
    const auto apart = [group](const Cluster& c) { return (group->bound.p_BS - c.bound.p_BS).norm(); };
    auto holder = std::find_if(out.begin(), out.end(), [&](const Cluster& c) {
      return apart(c) + group->bound.radius <= c.bound.radius + 1e-9;
    });
    if (holder == out.end()) {
      if (out.size() == PackedVehicle::kMostClusters) {
        holder = out.end() - 1;
        holder->bound.radius = std::max(holder->bound.radius, apart(*holder) + group->bound.radius);
      } else {
        out.push_back({group->bound, 0.0, {}});
        holder = out.end() - 1;
      }
    }
    holder->solid = std::max(holder->solid, solid - (group->part.p_BS - holder->bound.p_BS).norm());
    holder->groups.push_back(group);
  }
  return out;
}

PackedVehicle::Part packed_part(const vehicle::CollisionShape& shape, double scale) {
  PackedVehicle::Part out;
  out.kind = shape.kind;
  const Mat3 axes = shape.q_BS.toRotationMatrix();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<int>(k);
    out.center[k] = static_cast<float>(scale * shape.p_BS[i]);
    for (std::size_t j = 0; j < 3; ++j) out.axes[k][j] = static_cast<float>(axes(static_cast<int>(j), i));
    const bool half = shape.kind == Kind::box || (shape.kind == Kind::cylinder && k == 1);
    out.size[k] = static_cast<float>(scale * (half ? 0.5 : 1.0) * shape.size[i]);
  }
  return out;
}

}  // namespace

PackedVehicle packed(const VehicleSpheres& vehicle, double resolution, int voxels) {
  PackedVehicle out;
  const double scale = 1.0 / resolution;
  out.rounding = static_cast<float>(kLeastRounding +
                                    kRoundingOfPosition * (voxels + 2.0 + scale * vehicle.bounding_radius));
  out.radius = static_cast<float>(scale * vehicle.bounding_radius) + out.rounding;
  out.inscribed = static_cast<float>(scale * vehicle.inscribed_radius) - out.rounding;
  out.per_metre = static_cast<float>(scale);
  out.tolerance = static_cast<float>(scale * kMeasuredTo);
  const auto put = [&](PackedVehicle::Row& row, std::size_t lane, const BodySphere& s, bool real) {
    row.x[lane] = static_cast<float>(scale * s.p_BS.x());
    row.y[lane] = static_cast<float>(scale * s.p_BS.y());
    row.z[lane] = static_cast<float>(scale * s.p_BS.z());
    row.radius[lane] = real ? static_cast<float>(scale * s.radius) + out.rounding : kNothing;
  };
  const std::vector<Cluster> clusters = clusters_of(vehicle);
  constexpr std::size_t kLanes = PackedVehicle::kLanes;
  out.rows.push_back(0);
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    const Cluster& cluster = clusters[k];
    out.all_clusters |= std::uint64_t{1} << k;
    if (k % kLanes == 0) {
      out.clusters.emplace_back();
      out.solid.emplace_back();
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        put(out.clusters.back(), lane, cluster.bound, false);
        out.solid.back()[lane] = kNothing;
      }
    }
    put(out.clusters.back(), k % kLanes, cluster.bound, true);
    out.solid.back()[k % kLanes] = std::max(0.0f, static_cast<float>(scale * cluster.solid) - out.rounding);
    std::size_t lane = kLanes;
    BodySphere last;
    for (const SphereGroup* group : cluster.groups) {
      for (const BodySphere& s : group->spheres) {
        if (lane == kLanes) {
          out.spheres.emplace_back();
          lane = 0;
        }
        put(out.spheres.back(), lane++, last = s, true);
        out.part_of.push_back(static_cast<std::uint16_t>(out.parts.size()));
      }
      out.parts.push_back(packed_part(group->part, scale));
    }
    for (; lane < kLanes; ++lane) {
      put(out.spheres.back(), lane, last, false);
      out.part_of.push_back(out.part_of.back());
    }
    out.rows.push_back(static_cast<std::uint32_t>(out.spheres.size()));
  }
  return out;
}

}  // namespace omniflight::planning
