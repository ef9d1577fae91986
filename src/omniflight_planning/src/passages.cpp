#include "passages.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::planning {
namespace {

constexpr double kBlock = 0.1;  // m, at most, unless a voxel is larger
constexpr int kLevels = 64;
constexpr std::size_t kBlocksBetweenLooks = 4096;

}  // namespace

Passages::Passages(const DistanceMap& map)
    : map_(map), voxels_(std::max(1, static_cast<int>(kBlock / map.resolution() + 1e-6))) {
  const auto& voxels = map.size();
  for (std::size_t k = 0; k < 3; ++k) size_[k] = (voxels[k] + voxels_ - 1) / voxels_;
  blocks_.assign(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
                     static_cast<std::size_t>(size_[2]),
                 Block{-1.0f, 0});
  std::uint32_t voxel = 0;
  for (int z = 0; z < voxels[2]; ++z)
    for (int y = 0; y < voxels[1]; ++y) {
      const std::size_t row = (static_cast<std::size_t>(z / voxels_) * static_cast<std::size_t>(size_[1]) +
                               static_cast<std::size_t>(y / voxels_)) *
                              static_cast<std::size_t>(size_[0]);
      for (int x = 0; x < voxels[0]; ++x, ++voxel) {
        Block& block = blocks_[row + static_cast<std::size_t>(x / voxels_)];
        if (const auto d = static_cast<float>(map.voxel_distance(x, y, z)); d > block.distance)
          block = {d, voxel};
      }
    }
}

std::size_t Passages::block_of(const Vec3& p) const {
  const auto at = map_.voxel_of(p);
  return (static_cast<std::size_t>(at[2] / voxels_) * static_cast<std::size_t>(size_[1]) +
          static_cast<std::size_t>(at[1] / voxels_)) *
             static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(at[0] / voxels_);
}

Vec3 Passages::place(std::size_t block) const {
  const auto nx = static_cast<std::uint32_t>(map_.size()[0]), ny = static_cast<std::uint32_t>(map_.size()[1]);
  const std::uint32_t v = blocks_[block].voxel;
  return map_.voxel_center(static_cast<int>(v % nx), static_cast<int>(v / nx % ny),
                           static_cast<int>(v / nx / ny));
}

template <class Visit>
void Passages::for_neighbours(std::size_t block, const Visit& visit) const {
  const auto nx = static_cast<std::size_t>(size_[0]), ny = static_cast<std::size_t>(size_[1]),
             nz = static_cast<std::size_t>(size_[2]);
  const std::size_t x = block % nx, y = block / nx % ny, z = block / nx / ny;
  if (x > 0) visit(block - 1);
  if (x + 1 < nx) visit(block + 1);
  if (y > 0) visit(block - nx);
  if (y + 1 < ny) visit(block + nx);
  if (z > 0) visit(block - nx * ny);
  if (z + 1 < nz) visit(block + nx * ny);
}

std::optional<std::vector<WayPlace>> Passages::widest_way(const Vec3& a, const Vec3& b, double least,
                                                          double wide, const Deadline& deadline) const {
  const std::size_t from = block_of(a), to = block_of(b);
  constexpr auto kNone = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> came_from(blocks_.size(), kNone);
  const auto level = [&](std::size_t block) {
    return std::clamp(static_cast<int>(blocks_[block].distance / wide * (kLevels - 1)), 0, kLevels - 1);
  };
  // the widest front first, and within it the oldest
  struct Queue {
    std::vector<std::uint32_t> blocks;
    std::size_t next = 0;
  };
  std::vector<Queue> queues(kLevels);
  queues[kLevels - 1].blocks.push_back(static_cast<std::uint32_t>(from));
  came_from[from] = static_cast<std::uint32_t>(from);
  std::size_t looked = 0;
  for (int front = kLevels - 1; front >= 0 && came_from[to] == kNone;) {
    Queue& queue = queues[static_cast<std::size_t>(front)];
    if (queue.next == queue.blocks.size()) {
      --front;
      continue;
    }
    if (++looked % kBlocksBetweenLooks == 0 && deadline.passed()) return std::nullopt;
    const std::size_t block = queue.blocks[queue.next++];
    for_neighbours(block, [&](std::size_t next) {
      if (came_from[next] != kNone) return;
      if (next != to && !(blocks_[next].distance > 0.0f && blocks_[next].distance >= least)) return;
      came_from[next] = static_cast<std::uint32_t>(block);
      queues[static_cast<std::size_t>(std::min(front, level(next)))].blocks.push_back(
          static_cast<std::uint32_t>(next));
    });
  }
  if (came_from[to] == kNone) return std::nullopt;
  std::vector<WayPlace> way{{b, map_.distance(b)}};
  for (std::size_t block = to; block != from; block = came_from[block])
    if (block != to) way.push_back({place(block), blocks_[block].distance});
  way.push_back({a, map_.distance(a)});
  std::reverse(way.begin(), way.end());
  return way;
}

bool Passages::may_pass(const Vec3& a, const Vec3& b, double least, const Deadline& deadline) const {
  const std::size_t from = block_of(a), to = block_of(b);
  std::vector<bool> seen(blocks_.size());
  std::vector<std::uint32_t> stack{static_cast<std::uint32_t>(from)};
  seen[from] = true;
  for (std::size_t looked = 0; !stack.empty() && !seen[to]; ++looked) {
    if (looked % kBlocksBetweenLooks == 0 && deadline.passed()) return true;
    const std::size_t block = stack.back();
    stack.pop_back();
    for_neighbours(block, [&](std::size_t next) {
      if (seen[next]) return;
      // an occupied voxel (distance 0) never lets the origin through, however large the voxels are
      if (next != to && !(blocks_[next].distance > 0.0f && blocks_[next].distance >= least)) return;
      seen[next] = true;
      stack.push_back(static_cast<std::uint32_t>(next));
    });
  }
  return seen[to];
}

void Passages::keep_to(const Vec3& lower, const Vec3& upper) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Vec3 p = place(i);
    if ((p - lower).minCoeff() < 0.0 || (upper - p).minCoeff() < 0.0) blocks_[i].distance = 0.0f;
  }
}

void Passages::close(const Vec3& p, double radius, double distance) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    if (block.distance > 0.0f && block.distance <= distance && (place(i) - p).norm() <= radius)
      block.distance = 0.0f;
  }
}

}  // namespace omniflight::planning
