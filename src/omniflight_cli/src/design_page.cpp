#include "design_page.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace omniflight::cli {
namespace {

using Point = std::pair<double, double>;

constexpr std::size_t kMostHulls = 6;  // more lines in one drawing are not told apart

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

/// The first and the last tilt, and some between.
std::vector<const allocation::DesignPoint*> chosen(const allocation::DesignResult& design) {
  std::vector<const allocation::DesignPoint*> out;
  const std::size_t n = design.points.size(), shown = std::min(n, kMostHulls);
  for (std::size_t k = 0; k < shown; ++k)
    out.push_back(&design.points[shown < 2 ? 0 : k * (n - 1) / (shown - 1)]);
  return out;
}

report::OutlineView view(const std::vector<const allocation::DesignPoint*>& points,
                         std::vector<Vec3> allocation::DesignPoint::*vertices, const std::string& quantity,
                         const std::string& unit, int across, int up) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  report::OutlineView out{.x_label = fmt::format("{}{} [{}]", quantity, kAxes[across], unit),
                          .y_label = fmt::format("{}{} [{}]", quantity, kAxes[up], unit)};
  for (const allocation::DesignPoint* p : points) {
    std::vector<Point> flat;
    for (const Vec3& v : p->*vertices) flat.emplace_back(v[across], v[up]);
    if (flat.empty()) flat.emplace_back(0, 0);
    auto corners = convex_hull(flat);
    if (corners.empty()) corners.push_back(flat.front());
    while (corners.size() < 3) corners.push_back(corners.back());  // a set that is a line or a point
    out.outlines.push_back({fmt::format("{:.4g} deg", to_degrees(p->alpha)), std::move(corners)});
  }
  return out;
}

}  // namespace

void design_verdict(report::Page& page, const allocation::DesignResult& design, const std::string& words) {
  if (design.omnidirectional_tilt)
    page.verdict(report::Tone::ok,
                 fmt::format("Hovers in every attitude from {:.1f} deg of tilt on",
                             to_degrees(*design.omnidirectional_tilt)),
                 words);
  else
    page.verdict(report::Tone::unknown, "Cannot hover in every attitude at any tilt", words);
}

void design_hulls(report::Page& page, const allocation::DesignResult& design) {
  const auto points = chosen(design);
  if (points.empty()) return;
  using allocation::DesignPoint;
  page.outlines(
      {.title = "Forces at zero torque, body axes: from above, and from the side",
       .views = {view(points, &DesignPoint::force_vertices, "F", "N", 0, 1),
                 view(points, &DesignPoint::force_vertices, "F", "N", 0, 2)},
       .circle = design.mass * kGravity,
       .circle_label = fmt::format("weight, {:.3g} N: a hull around all of it hovers in every attitude",
                                   design.mass * kGravity)});
  page.outlines({.title = "Torques at zero force, body axes",
                 .views = {view(points, &DesignPoint::torque_vertices, "M", "Nm", 0, 1),
                           view(points, &DesignPoint::torque_vertices, "M", "Nm", 0, 2)}});
}

}  // namespace omniflight::cli
