#include "omniflight_allocation/outline.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace omniflight::allocation {
namespace {

TEST(Outline, OfACubeFromAboveIsASquare) {
  std::vector<Vec3> cube;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) cube.emplace_back(x, y, z);
  cube.emplace_back(0.2, 0.3, 0.9);  // inside
  auto square = outline(cube, 0, 1);
  double twice_area = 0;
  for (std::size_t k = 0; k < square.size(); ++k) {
    const auto &a = square[k], &b = square[(k + 1) % square.size()];
    twice_area += a.first * b.second - b.first * a.second;
  }
  EXPECT_EQ(square.size(), 4u);
  EXPECT_DOUBLE_EQ(twice_area, 8.0) << "counterclockwise";
}

TEST(Outline, OfALineAPointAndNothingHasThreePoints) {
  EXPECT_EQ(outline({Vec3(0, 0, -1), Vec3(0, 0, 1)}, 0, 2).size(), 3u);
  EXPECT_EQ(outline({Vec3(0, 0, -1), Vec3(0, 0, 1)}, 0, 1).size(), 3u);
  EXPECT_EQ(outline({}, 0, 1).size(), 3u);
}

}  // namespace
}  // namespace omniflight::allocation
