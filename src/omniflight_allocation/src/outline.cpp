#include "omniflight_allocation/outline.hpp"

#include <algorithm>

namespace omniflight::allocation {
namespace {

using Point = std::pair<double, double>;

/// Corners of the convex hull, counterclockwise (Andrew's monotone chain); of points on a line, its ends.
std::vector<Point> convex_hull(std::vector<Point> points) {
  std::sort(points.begin(), points.end());
  std::vector<Point> hull;
  const auto left_turn = [&](const Point& c) {
    const Point &a = hull[hull.size() - 2], &b = hull.back();
    return (b.first - a.first) * (c.second - a.second) - (b.second - a.second) * (c.first - a.first) > 0;
  };
  for (const bool upper : {false, true}) {
    const std::size_t kept = hull.size();
    for (const Point& p : points) {
      while (hull.size() >= kept + 2 && !left_turn(p)) hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();  // where the other chain begins
    std::reverse(points.begin(), points.end());
    if (upper) break;
  }
  return hull;
}

}  // namespace

std::vector<Point> outline(const std::vector<Vec3>& points, int across, int up) {
  std::vector<Point> flat;
  for (const Vec3& v : points) flat.emplace_back(v[across], v[up]);
  if (flat.empty()) flat.emplace_back(0, 0);
  auto corners = convex_hull(flat);
  if (corners.empty()) corners.push_back(flat.front());
  while (corners.size() < 3) corners.push_back(corners.back());
  return corners;
}

}  // namespace omniflight::allocation
