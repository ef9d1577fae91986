// Compiled once for every instruction set. No fused multiply-add, no contraction, and rows of eight whatever
// the width of the vectors: every processor gives the same bits.
#include "pose_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

// processors without SSE4 take the plain path: every target costs seconds of compilation
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pose_kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
// after highway
#include "part_distance-inl.hpp"
#include "pose_field-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace omniflight::planning {
namespace HWY_NAMESPACE {

/// Of a vehicle with more room than this, spheres that hold whole clusters tell how much.
constexpr float kCoarse = 0.08f;  // m
/// Parts are measured where their spheres leave less, and as far as this.
constexpr float kReach = 0.02f;         // m
constexpr std::size_t kMostSpans = 64;  // of a motion, at once

/// Where the spheres of the clusters are that will be asked, which are read meanwhile.
class Ahead {
 public:
  HWY_INLINE Ahead(const Field& field, const PackedVehicle& vehicle, const Placed& at, std::uint64_t clusters)
      : field_(field), vehicle_(vehicle), at_(at) {
    for (; clusters != 0; clusters &= clusters - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(clusters));
      for (std::uint32_t row = vehicle.rows[k]; row < vehicle.rows[k + 1] && count_ < kMost; ++row) {
        field.find(at, vehicle.spheres[row], cells_[count_]);
        field.fetch(cells_[count_++]);
      }
    }
  }
  /// Of the next row in the same order.
  HWY_INLINE const Field::Cells& next(std::uint32_t row) {
    if (next_ < count_) return cells_[next_++];
    field_.find(at_, vehicle_.spheres[row], cells_[0]);
    return cells_[0];
  }

 private:
  static constexpr std::size_t kMost = 40;  // rows
  const Field& field_;
  const PackedVehicle& vehicle_;
  const Placed& at_;
  Field::Cells cells_[kMost];
  std::size_t count_ = 0, next_ = 0;
};

/// Asks the spheres of a cluster. False when one of them is certainly too near.
HWY_INLINE bool ask_cluster(const Field& field, const PackedVehicle& vehicle, Ahead& ahead, std::size_t k,
                            float must, float limit, float& least, Open& open, bool& all_fit) {
  for (std::uint32_t row = vehicle.rows[k]; row < vehicle.rows[k + 1]; ++row) {
    const Told told = ask_spheres(field, ahead.next(row), vehicle.spheres[row], must, limit);
    if (told.hit != 0) return false;
    least = std::min(least, told.least);
    for (std::uint32_t bits = told.open; bits != 0; bits &= bits - 1) {
      if (open.count == kMostOpen) {
        all_fit = false;
        break;
      }
      open.spheres[open.count++] =
          static_cast<std::uint16_t>(kLanes * row + static_cast<std::uint32_t>(std::countr_zero(bits)));
    }
  }
  return true;
}

float RoomInBlocks(const VoxelBlocks& blocks, const PackedVehicle& vehicle, const GridPose& pose, float must,
                   float enough) {
  const Field field(blocks);
  const Placed at(pose);
  const float coarse = std::min(enough, must + kCoarse * vehicle.per_metre);
  const auto broad = field.broad(at);
  const float whole = broad.lower - vehicle.radius;
  if (whole >= coarse) return whole;
  if (broad.upper <= must + vehicle.inscribed) return 0.0f;

  alignas(32) float limits[kLanes];
  std::fill_n(limits, kLanes, coarse);
  alignas(32) float lowers[PackedVehicle::kMostClusters];
  float best = enough;
  std::uint64_t open_clusters = 0;
  Field::Cells cells[PackedVehicle::kMostClusters / kLanes];
  for (std::size_t row = 0; row < vehicle.clusters.size(); ++row) {
    field.find(at, vehicle.clusters[row], cells[row]);
    field.fetch(cells[row]);
  }
  for (std::size_t row = 0; row < vehicle.clusters.size(); ++row) {
    const Told told = ask_clusters(field, cells[row], vehicle.clusters[row], vehicle.solid[row], must, limits,
                                   lowers + kLanes * row);
    if (told.hit != 0) return 0.0f;
    best = std::min(best, told.least);
    open_clusters |= std::uint64_t{told.open} << (kLanes * row);
  }
  const float measured = std::min(enough, must + kReach * vehicle.per_metre);
  if (open_clusters == 0) return best;
  Ahead ahead(field, vehicle, at, open_clusters);
  Open open;
  for (; open_clusters != 0; open_clusters &= open_clusters - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(open_clusters));
    float least = kFar;
    bool all_fit = true;
    const std::size_t before = open.count;
    if (!ask_cluster(field, vehicle, ahead, k, must, measured, least, open, all_fit)) return 0.0f;
    if (!all_fit || lowers[k] >= measured) {  // the cluster counts by the sphere that holds it
      if (open.count > before || !all_fit) least = lowers[k];
      open.count = before;
    }
    best = std::min(best, std::max(lowers[k], least));
  }
  if (open.count == 0) return best;
  return std::min(best, measure(field, vehicle, at, open.spheres, open.count, must, measured));
}

struct Span {
  GridPose a, b;
  float half;              ///< share of the motion
  std::uint64_t clusters;  ///< those not known to be free
};

HWY_INLINE GridPose middle(const GridPose& a, const GridPose& b) {
  GridPose out;
  double square = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    out.q[k] = a.q[k] + b.q[k];
    square += out.q[k] * out.q[k];
  }
  const double inverse = 1.0 / std::sqrt(square);
  for (double& x : out.q) x *= inverse;
  for (std::size_t k = 0; k < 3; ++k) out.p[k] = 0.5 * (a.p[k] + b.p[k]);
  return out;
}

/// How far the points of clusters, and of the whole vehicle, move at most: the shortest rotation turns about
/// an axis of the body.
struct Travel {
  alignas(32) float clusters[PackedVehicle::kMostClusters];
  float whole;
};

HWY_INLINE Travel travel(const PackedVehicle& vehicle, const GridPose& a, const GridPose& b) {
  Travel out;
  double way = 0.0, v[3];  // v: of the quaternion from a to b, in the body
  for (std::size_t k = 0; k < 3; ++k) way += (b.p[k] - a.p[k]) * (b.p[k] - a.p[k]);
  way = std::sqrt(way);
  const auto& p = a.q;
  const auto& q = b.q;
  v[0] = p[3] * q[0] - p[0] * q[3] - p[1] * q[2] + p[2] * q[1];
  v[1] = p[3] * q[1] - p[1] * q[3] - p[2] * q[0] + p[0] * q[2];
  v[2] = p[3] * q[2] - p[2] * q[3] - p[0] * q[1] + p[1] * q[0];
  const double w = std::abs(p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]);
  const double sine = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double angle = 2.0 * std::atan2(sine, w);
  constexpr double kUp = 1.0 + 1e-5;  // single precision below
  const auto length = static_cast<float>(kUp * way + vehicle.rounding),
             turn = static_cast<float>(kUp * angle);
  float n[3] = {};
  if (sine > 1e-12)
    for (int k = 0; k < 3; ++k) n[k] = static_cast<float>(v[k] / sine);
  out.whole = length + turn * vehicle.radius;
  for (std::size_t row = 0; row < vehicle.clusters.size(); ++row) {
    const PackedVehicle::Row& c = vehicle.clusters[row];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float x = n[1] * c.z[lane] - n[2] * c.y[lane], y = n[2] * c.x[lane] - n[0] * c.z[lane],
                  z = n[0] * c.y[lane] - n[1] * c.x[lane];
      const float arm = std::sqrt(x * x + y * y + z * z) + std::max(0.0f, c.radius[lane]);
      out.clusters[kLanes * row + lane] = length + turn * arm;
    }
  }
  return out;
}

bool MotionInBlocks(const VoxelBlocks& blocks, const PackedVehicle& vehicle, const GridPose& a,
                    const GridPose& b, float must, float least) {
  const Field field(blocks);
  const Travel moved = travel(vehicle, a, b);
  const float measured = kReach * vehicle.per_metre;
  Span spans[kMostSpans];
  std::size_t first = 0, count = 1;
  spans[0] = {a, b, 0.5f, vehicle.all_clusters};
  double dot = 0.0;
  for (std::size_t k = 0; k < 4; ++k) dot += a.q[k] * b.q[k];
  if (dot < 0.0)
    for (double& x : spans[0].b.q) x = -x;
  Open open;
  alignas(32) float limits[PackedVehicle::kMostClusters], lowers[kLanes];
  while (count > 0) {
    // the oldest first, so that the motion is looked at evenly; where they become many, the newest
    const bool oldest = count < kMostSpans / 2;
    const std::size_t taken = (oldest ? first : first + count - 1) % kMostSpans;
    Span span = spans[taken];
    --count;
    if (oldest) first = (first + 1) % kMostSpans;
    const GridPose mid = middle(span.a, span.b);
    const Placed at(mid);
    if (field.broad(at).lower - vehicle.radius >= must + span.half * moved.whole) continue;
    for (std::size_t row = 0; row < vehicle.clusters.size(); ++row) {
      const std::uint64_t asked = span.clusters >> (kLanes * row) & 0xFF;
      if (asked == 0) continue;
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        limits[kLanes * row + lane] = must + span.half * moved.clusters[kLanes * row + lane];
      Field::Cells cells;
      field.find(at, vehicle.clusters[row], cells);
      const Told told = ask_clusters(field, cells, vehicle.clusters[row], vehicle.solid[row], must,
                                     limits + kLanes * row, lowers);
      if (told.hit != 0) return false;
      span.clusters &= ~((asked & ~std::uint64_t{told.open}) << (kLanes * row));
    }
    Ahead ahead(field, vehicle, at, span.clusters);
    for (std::uint64_t left = span.clusters; left != 0; left &= left - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(left));
      float spheres = kFar;
      bool all_fit = true;
      open.count = 0;
      if (!ask_cluster(field, vehicle, ahead, k, must, limits[k], spheres, open, all_fit)) return false;
      bool is_free = open.count == 0;
      const float way = span.half * moved.clusters[k];
      if (!is_free && way <= measured && all_fit) {
        const float near = measure(field, vehicle, at, open.spheres, open.count, must, limits[k]);
        if (near <= must) return false;
        is_free = near >= limits[k];
      }
      if (is_free)
        span.clusters &= ~(std::uint64_t{1} << k);
      else if (way <= least)
        return false;
    }
    if (span.clusters == 0) continue;
    if (count + 2 > kMostSpans) return false;  // a motion of more than 2^30 times `least`
    const float half = 0.5f * span.half;
    spans[(first + count) % kMostSpans] = {span.a, mid, half, span.clusters};
    spans[(first + count + 1) % kMostSpans] = {mid, span.b, half, span.clusters};
    count += 2;
  }
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::planning
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace omniflight::planning {

HWY_EXPORT(RoomInBlocks);
HWY_EXPORT(MotionInBlocks);

float room_in_blocks(const VoxelBlocks& blocks, const PackedVehicle& vehicle, const GridPose& pose,
                     float must, float enough) {
  return HWY_DYNAMIC_DISPATCH(RoomInBlocks)(blocks, vehicle, pose, must, enough);
}

bool motion_in_blocks(const VoxelBlocks& blocks, const PackedVehicle& vehicle, const GridPose& a,
                      const GridPose& b, float must, float least) {
  return HWY_DYNAMIC_DISPATCH(MotionInBlocks)(blocks, vehicle, a, b, must, least);
}

}  // namespace omniflight::planning
#endif
