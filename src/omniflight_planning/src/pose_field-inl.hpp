// Of pose_kernel.cpp: look-ups of a vehicle's spheres in the distance field, a row at a time.
#if defined(OMNIFLIGHT_PLANNING_POSE_FIELD_INL) == \
    defined(HWY_TARGET_TOGGLE)  // once for every instruction set
#ifdef OMNIFLIGHT_PLANNING_POSE_FIELD_INL
#undef OMNIFLIGHT_PLANNING_POSE_FIELD_INL
#else
#define OMNIFLIGHT_PLANNING_POSE_FIELD_INL
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hwy/highway.h"
#include "pose_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace omniflight::planning {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Kind = vehicle::CollisionShape::Kind;

constexpr int kLanes = PackedVehicle::kLanes;
using D = hn::CappedTag<float, kLanes>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;
constexpr D d{};
constexpr DI di{};
constexpr int kWidth = static_cast<int>(hn::MaxLanes(D{}));

constexpr float kFar = 1e30f;

HWY_INLINE V set(float x) { return hn::Set(d, x); }

HWY_INLINE std::uint32_t bits_of(M m, int first) {
  std::uint64_t part = 0;
  hn::StoreMaskBits(d, m, reinterpret_cast<std::uint8_t*>(&part));
  return static_cast<std::uint32_t>(part) << first;
}

struct Placed {
  float r[3][3];  ///< rotation matrix
  float t[3];

  explicit Placed(const GridPose& pose) {
    const double x = pose.q[0], y = pose.q[1], z = pose.q[2], w = pose.q[3];
    const double rotation[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                                   {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                                   {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) r[i][j] = static_cast<float>(rotation[i][j]);
      t[i] = static_cast<float>(std::clamp(pose.p[static_cast<std::size_t>(i)], -1e9, 1e9));
    }
  }
  float at(int i, float x, float y, float z) const {
    return ((r[i][0] * x + r[i][1] * y) + r[i][2] * z) + t[i];
  }
  float turned(int i, const std::array<float, 3>& v) const {
    return (r[i][0] * v[0] + r[i][1] * v[1]) + r[i][2] * v[2];
  }
};

/// The distance field, and what is asked of it.
class Field {
 public:
  explicit Field(const VoxelBlocks& b)
      : near_(b.blocks.front().near.data()),
        blocks_(b),
        nx_(b.count[0]),
        nxy_(b.count[1]),
        quantum_(b.quantum),
        top_(b.top) {
    for (std::size_t k = 0; k < 3; ++k) last_[k] = static_cast<float>(VoxelBlocks::kEdge * b.count[k]) - 0.5f;
  }

  /// The voxels that hold a row's centres, and how far these are from the middle of theirs.
  struct alignas(32) Cells {
    std::int32_t byte[kLanes];
    float off[kLanes];
  };
  HWY_INLINE void find(const Placed& at, const PackedVehicle::Row& row, Cells& out) const {
    for (int first = 0; first < kLanes; first += kWidth) find(at, row, first, out);
  }
  /// Begins to read them: what many rows need comes in the time of one.
  HWY_INLINE void fetch(const Cells& cells) const {
    for (const std::int32_t byte : cells.byte) __builtin_prefetch(near_ + byte);
  }

  struct Bounds {
    V lower, upper;
  };
  /// Of the distance of the spheres' centres, in the lanes from `first` on.
  HWY_INLINE Bounds look(const Cells& cells, int first) const {
    const V off = hn::Load(d, cells.off + first), b = hn::ConvertTo(d, bytes(cells.byte + first));
    const V upper = hn::Add(hn::Mul(hn::Add(b, set(1.0f)), set(quantum_)), off);
    return {hn::Sub(hn::Mul(b, set(quantum_)), off),
            hn::IfThenElse(hn::Ge(b, set(static_cast<float>(top_))), set(kFar),
                           hn::IfThenZeroElse(hn::Eq(b, hn::Zero(d)), upper))};
  }
  struct Broad {
    float lower, upper;
  };
  /// Of the distance of the body's origin.
  HWY_INLINE Broad broad(const Placed& at) const {
    constexpr int kEdge = VoxelBlocks::kEdge;
    int block[3];
    float square = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float p = at.t[k];
      block[k] = static_cast<int>(std::min(std::max(p, 0.0f), last_[k])) / kEdge;
      const float off = p - (static_cast<float>(kEdge * block[k]) + 2.5f);
      square += off * off;
    }
    const float off = std::sqrt(square);
    const int b = blocks_.broad[static_cast<std::size_t>((block[2] * nxy_ + block[1]) * nx_ + block[0])];
    const auto near = static_cast<float>(b);
    return {near * blocks_.broad_quantum - off,
            b >= blocks_.broad_top ? kFar : (near + 1.0f) * blocks_.broad_quantum + off};
  }

  const VoxelBlocks& blocks() const { return blocks_; }

 private:
  HWY_INLINE void find(const Placed& at, const PackedVehicle::Row& row, int first, Cells& out) const {
    const V x = hn::Load(d, row.x.data() + first), y = hn::Load(d, row.y.data() + first),
            z = hn::Load(d, row.z.data() + first);
    V square = hn::Zero(d);
    VI cell[3];
    for (int k = 0; k < 3; ++k) {
      const V p = hn::Add(hn::Add(hn::Add(hn::Mul(set(at.r[k][0]), x), hn::Mul(set(at.r[k][1]), y)),
                                  hn::Mul(set(at.r[k][2]), z)),
                          set(at.t[k]));
      cell[k] = hn::ConvertTo(di, hn::Min(hn::Max(p, hn::Zero(d)), set(last_[k])));
      const V off = hn::Sub(p, hn::Add(hn::ConvertTo(d, cell[k]), set(0.5f)));
      square = hn::Add(square, hn::Mul(off, off));
    }
    hn::Store(hn::Sqrt(square), d, out.off + first);
    const VI block = hn::Add(
        hn::Mul(hn::Add(hn::Mul(hn::ShiftRight<2>(cell[2]), hn::Set(di, nxy_)), hn::ShiftRight<2>(cell[1])),
                hn::Set(di, nx_)),
        hn::ShiftRight<2>(cell[0]));
    const VI three = hn::Set(di, 3);
    const VI within = hn::Or(hn::ShiftLeft<4>(hn::And(cell[2], three)),
                             hn::Or(hn::ShiftLeft<2>(hn::And(cell[1], three)), hn::And(cell[0], three)));
    hn::Store(hn::Or(hn::ShiftLeft<6>(block), within), di, out.byte + first);
  }

  HWY_INLINE VI bytes(const std::int32_t* at) const {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
    // four bytes, of which the first one counts: there is a block more than anybody asks for
    return hn::And(hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(near_), hn::Load(di, at)),
                   hn::Set(di, 255));
#else
    alignas(32) std::int32_t value[kLanes];
    for (int i = 0; i < kWidth; ++i) value[i] = near_[at[i]];
    return hn::Load(di, value);
#endif
  }

  const std::uint8_t* near_;
  const VoxelBlocks& blocks_;
  std::int32_t nx_, nxy_;
  float quantum_;
  int top_;
  float last_[3];
};

/// What spheres, or clusters, say of themselves.
struct Told {
  std::uint32_t hit = 0;   ///< those with a point that is certainly too near
  std::uint32_t open = 0;  ///< those that are not farther away than the limit
  float least = kFar;      ///< distance of the others
};

HWY_INLINE Told ask_clusters(const Field& field, const Field::Cells& cells, const PackedVehicle::Row& row,
                             const PackedVehicle::Lanes& solid, float must, const float* limits,
                             float* lowers) {
  Told out;
  V least = set(kFar);
  for (int i = 0; i < kLanes; i += kWidth) {
    const auto bounds = field.look(cells, i);
    const V lower = hn::Sub(bounds.lower, hn::Load(d, row.radius.data() + i));
    const M open = hn::Lt(lower, hn::Load(d, limits + i));
    hn::Store(lower, d, lowers + i);
    least = hn::Min(least, hn::IfThenElse(open, set(kFar), lower));
    out.open |= bits_of(open, i);
    out.hit |= bits_of(hn::Le(bounds.upper, hn::Add(hn::LoadU(d, solid.data() + i), set(must))), i);
  }
  out.least = hn::GetLane(hn::MinOfLanes(d, least));
  return out;
}

HWY_INLINE Told ask_spheres(const Field& field, const Field::Cells& cells, const PackedVehicle::Row& row,
                            float must, float limit) {
  Told out;
  V least = set(kFar);
  for (int i = 0; i < kLanes; i += kWidth) {
    const auto bounds = field.look(cells, i);
    const V lower = hn::Sub(bounds.lower, hn::Load(d, row.radius.data() + i));
    const M open = hn::Lt(lower, set(limit));
    least = hn::Min(least, hn::IfThenElse(open, set(kFar), lower));
    out.open |= bits_of(open, i);
    out.hit |= bits_of(hn::Le(bounds.upper, set(must)), i);
  }
  out.least = hn::GetLane(hn::MinOfLanes(d, least));
  return out;
}

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::planning
HWY_AFTER_NAMESPACE();

#endif
