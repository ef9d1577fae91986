#include "omniflight_planning/voxel_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

/// Quanta: a sixteenth of a voxel, but bytes should reach this far where voxels are small, so that one byte
/// tells whether a rotor is free.
constexpr double kReachOfBytes = 0.32;        // m
constexpr double kFinest = 1.0 / 16.0;        // voxels
constexpr double kCoarsest = 1.0 / 3.0;       // voxels: a free voxel's centre is half a voxel from any box
constexpr float kRoundedDown = 1.0f - 1e-6f;  // the field is exact to some float steps

/// Not 0 where the voxel is free, also where distances are cut off below a quantum.
std::uint8_t quanta(float field, float count, int top) {
  return field == 0.0f ? 0 : static_cast<std::uint8_t>(std::clamp(static_cast<int>(count), 1, top));
}

}  // namespace

VoxelBlocks VoxelBlocks::create(const std::vector<float>& field, const std::array<int, 3>& size,
                                double resolution, double max_distance) {
  VoxelBlocks out;
  out.size = size;
  std::size_t blocks = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    out.count[k] = (size[k] + 2 + kEdge - 1) / kEdge;
    blocks *= static_cast<std::size_t>(out.count[k]);
  }
  const double reach = max_distance / resolution;
  const auto top = [reach](float quantum) {
    return static_cast<int>(std::clamp(reach / quantum, 1.0, 255.0));
  };
  out.quantum = static_cast<float>(std::clamp(kReachOfBytes / resolution / 255.0, kFinest, kCoarsest));
  out.top = top(out.quantum);
  out.broad_quantum = std::max(out.quantum, static_cast<float>(reach / 255.0));
  out.broad_top = top(out.broad_quantum);
  out.blocks.resize(blocks + 1);
  out.surface.resize(blocks);
  out.broad.resize(blocks);
  out.update(field, resolution, {0, 0, 0}, {size[0] - 1, size[1] - 1, size[2] - 1});
  return out;
}

void VoxelBlocks::update(const std::vector<float>& field, double resolution, const std::array<int, 3>& first,
                         const std::array<int, 3>& last) {
  const auto [nx, ny, nz] = size;
  const auto row_of = [&](int y, int z) {
    return &field[(static_cast<std::size_t>(z) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(y)) *
                  static_cast<std::size_t>(nx)];
  };
  const auto per_metre = static_cast<float>(kRoundedDown / (resolution * quantum));
  const auto per_metre_broad = static_cast<float>(kRoundedDown / (resolution * broad_quantum));
  const auto edge = static_cast<float>(resolution);
  const auto half = 0.5f * edge;
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y) {
      const float* row = row_of(y, z);
      const float beside = edge * static_cast<float>(std::min({y, ny - 1 - y, z, nz - 1 - z})) + half;
      const std::size_t first_block = block_of(0, y + 1, z + 1);
      const int first_byte = within(0, y + 1, z + 1);
      const bool of_broad = (y + 1) % kEdge == 2 && (z + 1) % kEdge == 2;
      for (int x = first[0]; x <= last[0]; ++x) {
        const float ends = edge * static_cast<float>(std::min(x, nx - 1 - x)) + half;
        const float near = std::min({row[x], beside, ends});
        const auto at = static_cast<unsigned>(x + 1);
        blocks[first_block + at / kEdge].near[static_cast<unsigned>(first_byte) + at % kEdge] =
            quanta(row[x], near * per_metre, top);
        if (of_broad && at % kEdge == 2)
          broad[first_block + at / kEdge] =
              static_cast<std::uint8_t>(std::min(broad_top, static_cast<int>(near * per_metre_broad)));
      }
    }

  // Occupied voxels as bits, of the blocks that hold these voxels and their neighbours and of those around
  // them; from them the ones with a free voxel across a face.
  std::array<int, 3> from{}, to{}, low{}, extent{};
  for (std::size_t k = 0; k < 3; ++k) {
    from[k] = first[k] / kEdge;  // the neighbour's place in the grid is the voxel's in the map
    to[k] = std::min(count[k] - 1, (last[k] + 2) / kEdge);
    low[k] = from[k] - 1;
    extent[k] = to[k] - from[k] + 3;
  }
  const auto bits_at = [&](int bx, int by, int bz) {
    return (static_cast<std::size_t>(bz - low[2]) * static_cast<std::size_t>(extent[1]) +
            static_cast<std::size_t>(by - low[1])) *
               static_cast<std::size_t>(extent[0]) +
           static_cast<std::size_t>(bx - low[0]);
  };
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(extent[0]) * static_cast<std::size_t>(extent[1]) *
                                      static_cast<std::size_t>(extent[2]),
                                  ~std::uint64_t{0});
  for (int bz = std::max(0, low[2]); bz < std::min(count[2], to[2] + 2); ++bz)
    for (int by = std::max(0, low[1]); by < std::min(count[1], to[1] + 2); ++by)
      for (int bx = std::max(0, low[0]); bx < std::min(count[0], to[0] + 2); ++bx) {
        const Block& block = blocks[block_of(kEdge * bx, kEdge * by, kEdge * bz)];
        std::uint64_t all = 0;
        for (std::size_t i = 0; i < 64; ++i) all |= std::uint64_t{block.near[i] == 0} << i;
        bits[bits_at(bx, by, bz)] = all;
      }
  constexpr std::uint64_t kX0 = 0x1111'1111'1111'1111, kX3 = kX0 << 3;
  constexpr std::uint64_t kY0 = 0x000F'000F'000F'000F, kY3 = kY0 << 12;
  for (int bz = from[2]; bz <= to[2]; ++bz)
    for (int by = from[1]; by <= to[1]; ++by)
      for (int bx = from[0]; bx <= to[0]; ++bx) {
        const auto at = [&](int dx, int dy, int dz) { return bits[bits_at(bx + dx, by + dy, bz + dz)]; };
        const std::uint64_t here = at(0, 0, 0);
        const std::uint64_t hidden = ((here << 1 & ~kX0) | (at(-1, 0, 0) >> 3 & kX0)) &
                                     ((here >> 1 & ~kX3) | (at(1, 0, 0) << 3 & kX3)) &
                                     ((here << 4 & ~kY0) | (at(0, -1, 0) >> 12 & kY0)) &
                                     ((here >> 4 & ~kY3) | (at(0, 1, 0) << 12 & kY3)) &
                                     (here << 16 | at(0, 0, -1) >> 48) & (here >> 16 | at(0, 0, 1) << 48);
        surface[block_of(kEdge * bx, kEdge * by, kEdge * bz)] = here & ~hidden;
      }
}

}  // namespace omniflight::planning
