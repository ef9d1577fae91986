#include "design_page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "omniflight_allocation/outline.hpp"

namespace omniflight::cli {
namespace {

constexpr std::size_t kMostHulls = 6;  // more lines in one drawing are not told apart

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
  for (const allocation::DesignPoint* p : points)
    out.outlines.push_back(
        {fmt::format("{:.4g} deg", to_degrees(p->alpha)), allocation::outline(p->*vertices, across, up)});
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
