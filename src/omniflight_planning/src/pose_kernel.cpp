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
/// Of a vehicle with more room than this, spheres that hold whole clusters tell how much.
constexpr float kCoarse = 0.08f;  // m
/// Parts are measured where their spheres leave less, and as far as this.
constexpr float kReach = 0.02f;         // m
constexpr std::size_t kMostOpen = 256;  // spheres; with more, poses count by their spheres
constexpr std::size_t kMostSpans = 64;  // of a motion, at once
constexpr int kMostProjections = 64;
constexpr std::size_t kKnownBlocks = 32;  // of a part

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

/// A convex part in the grid, and how far the cubes of voxels are from it; as Solid::distance_to_cube.
class PlacedPart {
 public:
  PlacedPart(const PackedVehicle::Part& part, const Placed& at) : kind_(part.kind) {
    for (int i = 0; i < 3; ++i) {
      center[i] = at.at(i, part.center[0], part.center[1], part.center[2]);
      size_[i] = part.size[static_cast<std::size_t>(i)];
      for (int k = 0; k < 3; ++k) axes_[k][i] = at.turned(i, part.axes[static_cast<std::size_t>(k)]);
    }
  }
  float center[3];

  /// The least lower bound of their distances, exact to the tolerance up to `enough`; 0 once one of them is
  /// not farther away than `must`. q: centres of cubes, less the part's.
  HWY_INLINE float distance(const float (*q)[kLanes], float must, float enough, float tolerance) const {
    float out = enough;
    for (int i = 0; i < kLanes; i += kWidth) {
      const Triple cubes{{hn::Load(d, q[0] + i), hn::Load(d, q[1] + i), hn::Load(d, q[2] + i)}};
      out = std::min(out, kind_ == Kind::cylinder ? of_cubes<Kind::cylinder>(cubes, must, enough, tolerance)
                          : kind_ == Kind::box    ? of_cubes<Kind::box>(cubes, must, enough, tolerance)
                                                  : of_cubes<Kind::sphere>(cubes, must, enough, tolerance));
      if (out <= must) break;
    }
    return out;
  }

 private:
  struct Triple {
    V v[3];
  };
  static HWY_INLINE V dot(const float* a, const Triple& b) {
    return hn::Add(hn::Add(hn::Mul(set(a[0]), b.v[0]), hn::Mul(set(a[1]), b.v[1])),
                   hn::Mul(set(a[2]), b.v[2]));
  }
  static HWY_INLINE V square(const Triple& a) {
    return hn::Add(hn::Add(hn::Mul(a.v[0], a.v[0]), hn::Mul(a.v[1], a.v[1])), hn::Mul(a.v[2], a.v[2]));
  }
  static HWY_INLINE V clip(V x, float most) { return hn::Min(hn::Max(x, set(-most)), set(most)); }
  static HWY_INLINE Triple in_cube(const Triple& x, const Triple& cube) {
    Triple out;
    for (int k = 0; k < 3; ++k) out.v[k] = hn::Add(cube.v[k], clip(hn::Sub(x.v[k], cube.v[k]), 0.5f));
    return out;
  }

  /// The point of the part nearest to x.
  template <Kind kKind>
  HWY_INLINE Triple nearest(const Triple& x) const {
    Triple out;
    if constexpr (kKind == Kind::box) {
      for (int k = 0; k < 3; ++k) out.v[k] = hn::Zero(d);
      for (int a = 0; a < 3; ++a) {
        const V along = clip(dot(axes_[a], x), size_[a]);
        for (int k = 0; k < 3; ++k) out.v[k] = hn::Add(out.v[k], hn::Mul(along, set(axes_[a][k])));
      }
      return out;
    }
    V along = hn::Zero(d);
    Triple across = x;
    if constexpr (kKind == Kind::cylinder) {
      along = dot(axes_[2], x);
      for (int k = 0; k < 3; ++k) across.v[k] = hn::Sub(x.v[k], hn::Mul(along, set(axes_[2][k])));
      along = clip(along, size_[1]);
    }
    const V length = hn::Sqrt(square(across));
    const V share = hn::Div(set(size_[0]), hn::Max(length, set(size_[0])));
    for (int k = 0; k < 3; ++k) {
      out.v[k] = hn::Mul(across.v[k], share);
      if constexpr (kKind == Kind::cylinder) out.v[k] = hn::Add(out.v[k], hn::Mul(along, set(axes_[2][k])));
    }
    return out;
  }

  /// How far the part reaches from its centre along unit vectors.
  template <Kind kKind>
  HWY_INLINE V reach(const Triple& unit) const {
    if constexpr (kKind == Kind::sphere) return set(size_[0]);
    if constexpr (kKind == Kind::box) {
      V sum = hn::Zero(d);
      for (int a = 0; a < 3; ++a) sum = hn::Add(sum, hn::Mul(hn::Abs(dot(axes_[a], unit)), set(size_[a])));
      return sum;
    }
    const V along = dot(axes_[2], unit);
    Triple across;
    for (int k = 0; k < 3; ++k) across.v[k] = hn::Sub(unit.v[k], hn::Mul(along, set(axes_[2][k])));
    return hn::Add(hn::Mul(hn::Sqrt(square(across)), set(size_[0])), hn::Mul(hn::Abs(along), set(size_[1])));
  }

  /// Gap along unit vectors: never more than the distance (separating axis).
  template <Kind kKind>
  HWY_INLINE V gap(const Triple& unit, const Triple& cube) const {
    V along = hn::Zero(d), sum = hn::Zero(d);
    for (int k = 0; k < 3; ++k) {
      along = hn::Add(along, hn::Mul(unit.v[k], cube.v[k]));
      sum = hn::Add(sum, hn::Abs(unit.v[k]));
    }
    return hn::Sub(hn::Sub(hn::Abs(along), hn::Mul(sum, set(0.5f))), reach<kKind>(unit));
  }

  template <Kind kKind>
  HWY_INLINE float of_cubes(const Triple& cube, float must, float enough, float tolerance) const {
    V low = hn::Zero(d);
    // faces first: between nearly parallel ones the projections below converge slowly
    for (int a = kKind == Kind::box ? 0 : kKind == Kind::cylinder ? 2 : 3; a < 3; ++a)
      low = hn::Max(low, gap<kKind>({{set(axes_[a][0]), set(axes_[a][1]), set(axes_[a][2])}}, cube));
    if constexpr (kKind != Kind::sphere)
      for (int k = 0; k < 3; ++k) {
        Triple unit{{hn::Zero(d), hn::Zero(d), hn::Zero(d)}};
        unit.v[k] = set(1.0f);
        low = hn::Max(low, gap<kKind>(unit, cube));
      }
    M done = hn::Ge(low, set(enough));
    Triple x = in_cube({{hn::Zero(d), hn::Zero(d), hn::Zero(d)}}, cube);
    // alternating projections (von Neumann; Cheney and Goldstein 1959): the distance of the points is an
    // upper bound, the gap along the line between them a lower one
    for (int i = 0; i < kMostProjections && !hn::AllTrue(d, done); ++i) {
      const Triple y = nearest<kKind>(x);
      Triple v;
      for (int k = 0; k < 3; ++k) v.v[k] = hn::Sub(x.v[k], y.v[k]);
      const V high = hn::Sqrt(square(v));
      if (!hn::AllFalse(d, hn::AndNot(done, hn::Le(high, set(std::max(must, tolerance)))))) return 0.0f;
      const V inverse = hn::Div(set(1.0f), hn::Max(high, set(tolerance)));
      for (int k = 0; k < 3; ++k) v.v[k] = hn::Mul(v.v[k], inverse);
      low = hn::IfThenElse(done, low, hn::Max(low, gap<kKind>(v, cube)));
      done = hn::Or(done, hn::Or(hn::Ge(low, set(enough)), hn::Le(hn::Sub(high, low), set(tolerance))));
      x = in_cube(y, cube);
    }
    return hn::GetLane(hn::MinOfLanes(d, low));
  }

  Kind kind_;
  float size_[3];
  float axes_[3][3];
};

/// Spheres that are not far enough away, cluster by cluster.
struct Open {
  std::uint16_t spheres[kMostOpen];
  std::size_t count = 0;
};

/// Of the parts that these spheres cover, measured to the voxels on the surface of obstacles in reach of the
/// spheres. What of a part comes nearest to an obstacle lies in one of its spheres. A part whose centre is
/// outside of obstacles touches none without touching a voxel of their surface. All up to `enough`; 0 once
/// something is not farther away than `must`.
HWY_INLINE float measure(const Field& field, const PackedVehicle& vehicle, const Placed& at,
                         const std::uint16_t* spheres, std::size_t count, float must, float enough) {
  constexpr int kEdge = VoxelBlocks::kEdge;
  const VoxelBlocks& blocks = field.blocks();
  const float asked = enough + vehicle.rounding;
  float out = asked;
  for (std::size_t i = 0; i < count && out > must;) {
    const std::uint16_t number = vehicle.part_of[spheres[i]];
    const PlacedPart part(vehicle.parts[number], at);
    alignas(32) float cubes[3][kLanes];
    int waiting = 0;
    struct {
      std::size_t block;
      std::uint64_t bits;
    } known[kKnownBlocks];
    std::size_t known_count = 0;
    for (; i < count && vehicle.part_of[spheres[i]] == number && out > must; ++i) {
      const PackedVehicle::Row& row = vehicle.spheres[spheres[i] / kLanes];
      const std::size_t lane = spheres[i] % kLanes;
      const float reach = row.radius[lane] + asked;
      int low[3], high[3];
      for (int k = 0; k < 3; ++k) {
        const float p = at.at(k, row.x[lane], row.y[lane], row.z[lane]);
        const auto last = static_cast<float>(kEdge * blocks.count[static_cast<std::size_t>(k)] - 1);
        low[k] = static_cast<int>(std::min(std::max(p - reach, 0.0f), last));
        high[k] = static_cast<int>(std::min(std::max(p + reach, 0.0f), last));
      }
      // bits of a block from its first to its last layer across each axis
      const auto layers = [&](int k, int block, std::uint64_t one, int step) {
        const int from = std::max(low[k] - kEdge * block, 0),
                  to = std::min(high[k] - kEdge * block, kEdge - 1);
        std::uint64_t all = 0;
        for (int layer = from; layer <= to; ++layer) all |= one << (step * layer);
        return all;
      };
      for (int bz = low[2] / kEdge; bz <= high[2] / kEdge && out > must; ++bz) {
        const std::uint64_t in_z = layers(2, bz, 0xFFFF, 16);
        for (int by = low[1] / kEdge; by <= high[1] / kEdge; ++by) {
          const std::uint64_t in_y = in_z & layers(1, by, 0x000F'000F'000F'000F, 4);
          for (int bx = low[0] / kEdge; bx <= high[0] / kEdge; ++bx) {
            const std::size_t block = blocks.block_of(kEdge * bx, kEdge * by, kEdge * bz);
            std::uint64_t bits = blocks.surface[block];
            if (bits == 0) continue;
            bits &= in_y & layers(0, bx, 0x1111'1111'1111'1111, 1);
            if (bits == 0) continue;
            std::size_t k = 0;
            while (k < known_count && known[k].block != block) ++k;
            if (k < known_count) {
              bits &= ~known[k].bits;
              known[k].bits |= bits;
            } else if (k < kKnownBlocks) {
              known[known_count++] = {block, bits};
            }
            for (; bits != 0; bits &= bits - 1) {
              const int bit = std::countr_zero(bits);
              cubes[0][waiting] = static_cast<float>(kEdge * bx + bit % kEdge) + 0.5f - part.center[0];
              cubes[1][waiting] =
                  static_cast<float>(kEdge * by + bit / kEdge % kEdge) + 0.5f - part.center[1];
              cubes[2][waiting] = static_cast<float>(kEdge * bz + bit / 16) + 0.5f - part.center[2];
              if (++waiting < kLanes) continue;
              waiting = 0;
              out = std::min(out, part.distance(cubes, must, asked, vehicle.tolerance));
              if (out <= must) return 0.0f;
            }
          }
        }
      }
    }
    if (waiting > 0) {
      for (int k = waiting; k < kLanes; ++k)
        for (auto& axis : cubes) axis[k] = axis[0];
      out = std::min(out, part.distance(cubes, must, asked, vehicle.tolerance));
    }
  }
  return out >= asked ? enough : std::max(0.0f, out - vehicle.rounding);
}

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
