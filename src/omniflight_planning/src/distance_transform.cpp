#include <algorithm>
#include <cmath>
#include <limits>

#include "omniflight_planning/map.hpp"

namespace omniflight::planning {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

/// Lower envelope along one line. A voxel with value f at position 2q (half voxels) reaches 2q-1 ... 2q+1 at
/// no cost, because its box does: (|d| - 1/2)^2 is the least of (d - s)^2 over s in {-1/2, 0, 1/2}.
class LineTransform {
 public:
  LineTransform(int length, float limit)
      : limit_(limit),
        sites_(static_cast<std::size_t>(2 * length + 1)),
        where_(sites_.size()),
        from_(sites_.size() + 1) {}

  void run(float* line, std::ptrdiff_t stride, int n) {
    const auto value = [&](int q) { return line[q * stride]; };
    int last = -1;
    for (int position = -1; position <= 2 * n - 1; ++position) {
      float f = kFar;
      if (position % 2 == 0) {
        f = value(position / 2);
      } else {
        const int left = (position - 1) / 2, right = (position + 1) / 2;  // position -1: left -1, right 0
        if (position > 0) f = value(left);
        if (right < n) f = std::min(f, value(right));
      }
      if (!(f < limit_)) continue;
      double start = -std::numeric_limits<double>::infinity();
      while (last >= 0) {
        const auto k = static_cast<std::size_t>(last);
        const double p = position, r = where_[k];
        start =
            ((static_cast<double>(f) + p * p) - (static_cast<double>(sites_[k]) + r * r)) / (2.0 * (p - r));
        if (start > from_[k]) break;
        --last;
        start = -std::numeric_limits<double>::infinity();
      }
      ++last;
      const auto k = static_cast<std::size_t>(last);
      sites_[k] = f;
      where_[k] = position;
      from_[k] = start;
    }
    if (last < 0) {
      for (int q = 0; q < n; ++q) line[q * stride] = limit_;
      return;
    }
    std::size_t k = 0;
    for (int q = 0; q < n; ++q) {
      while (static_cast<int>(k) < last && from_[k + 1] < 2 * q) ++k;
      const auto d = static_cast<float>(2 * q - where_[k]);
      line[q * stride] = std::min(limit_, sites_[k] + d * d);
    }
  }

 private:
  float limit_;
  std::vector<float> sites_;
  std::vector<int> where_;
  std::vector<double> from_;
};

}  // namespace

std::vector<float> squared_distances_to_boxes(const std::vector<std::uint8_t>& occupied,
                                              const std::array<int, 3>& size, float limit,
                                              const Deadline& deadline) {
  const std::ptrdiff_t nx = size[0], ny = size[1], nz = size[2];
  std::vector<float> field(occupied.size());
  for (std::size_t i = 0; i < occupied.size(); ++i) field[i] = occupied[i] ? 0.0f : limit;
  LineTransform line(std::max({size[0], size[1], size[2]}), limit);
  for (std::ptrdiff_t z = 0; z < nz; ++z) {
    if (deadline.passed()) return {};
    for (std::ptrdiff_t y = 0; y < ny; ++y)
      line.run(&field[static_cast<std::size_t>((z * ny + y) * nx)], 1, size[0]);
  }
  for (std::ptrdiff_t z = 0; z < nz; ++z) {
    if (deadline.passed()) return {};
    for (std::ptrdiff_t x = 0; x < nx; ++x)
      line.run(&field[static_cast<std::size_t>(z * ny * nx + x)], nx, size[1]);
  }
  for (std::ptrdiff_t y = 0; y < ny; ++y) {
    if (deadline.passed()) return {};
    for (std::ptrdiff_t x = 0; x < nx; ++x)
      line.run(&field[static_cast<std::size_t>(y * nx + x)], nx * ny, size[2]);
  }
  return field;
}

}  // namespace omniflight::planning
