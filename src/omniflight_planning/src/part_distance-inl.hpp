// Of pose_kernel.cpp: how far the parts of a vehicle are from the voxels of obstacles.
#if defined(OMNIFLIGHT_PLANNING_PART_DISTANCE_INL) == \
    defined(HWY_TARGET_TOGGLE)  // once for every instruction set
#ifdef OMNIFLIGHT_PLANNING_PART_DISTANCE_INL
#undef OMNIFLIGHT_PLANNING_PART_DISTANCE_INL
#else
#define OMNIFLIGHT_PLANNING_PART_DISTANCE_INL
#endif

#include <algorithm>
#include <bit>
#include <cstdint>

#include "pose_field-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace omniflight::planning {
namespace HWY_NAMESPACE {

constexpr std::size_t kMostOpen = 256;  // spheres; with more, poses count by their spheres
constexpr int kMostProjections = 64;
constexpr std::size_t kKnownBlocks = 32;  // of a part

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

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::planning
HWY_AFTER_NAMESPACE();

#endif
