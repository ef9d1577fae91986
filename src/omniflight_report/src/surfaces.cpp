#include <algorithm>
#include <array>
#include <cmath>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

Status check_surface(const Surface& s) {
  for (const auto& p : s.points)
    for (const double x : p)
      if (!std::isfinite(x)) return bad_input("surface '" + s.name + "' has a point that is not finite");
  const auto count = static_cast<int>(s.points.size());
  for (const auto& triangle : s.triangles)
    for (const int i : triangle)
      if (i < 0 || i >= count) return bad_input("surface '" + s.name + "' has no point " + std::to_string(i));
  return {};
}

std::string json_number(double value) {
  const std::string list = json_array(std::array{value});  // of one
  return list.substr(1, list.size() - 2);
}

std::string json_of(const Surface& s) {
  std::string points, corners;
  for (const auto& p : s.points) points += (points.empty() ? "" : ",") + json_array(p);
  for (const auto& [a, b, c] : s.triangles)
    corners += (corners.empty() ? "[" : ",[") + std::to_string(a) + "," + std::to_string(b) + "," +
               std::to_string(c) + "]";
  return "{\"points\":[" + points + "],\"triangles\":[" + corners + "]}";
}

}  // namespace

Result<std::string> render(const Surfaces& all) {
  if (all.surfaces.empty()) return bad_input("there must be at least one surface");
  if (!std::isfinite(all.sphere)) return bad_input("the sphere must be finite");
  double largest = all.sphere;
  for (const Surface& s : all.surfaces) {
    if (auto ok = check_surface(s); !ok) return Failure(ok.error());
    for (const auto& p : s.points) largest = std::max(largest, std::hypot(p[0], p[1], p[2]));
  }
  if (!(largest > 0)) largest = 1;
  std::string out = "<figure class=\"surfaces\"><figcaption>" + escape_html(all.title) +
                    "</figcaption><div class=\"views\">",
              surfaces;
  for (const Surface& s : all.surfaces) {
    out += "<div class=\"view\"><p>" + escape_html(s.name) +
           "</p><canvas style=\"height:320px\" tabindex=\"0\" role=\"img\" aria-label=\"" +
           escape_html(all.title + ": " + s.name) + "\"></canvas></div>";
    surfaces += (surfaces.empty() ? "" : ",") + json_of(s);
  }
  out += "</div>";
  if (all.sphere > 0) out += "<p class=\"footnote\">Grey ball: " + escape_html(all.sphere_label) + "</p>";
  return out + "<script type=\"application/json\">{\"quantity\":" + json_string(all.quantity) +
         ",\"unit\":" + json_string(all.unit) + ",\"sphere\":" + json_number(all.sphere) +
         ",\"largest\":" + json_number(largest) + ",\"surfaces\":[" + surfaces + "]}</script></figure>\n";
}

}  // namespace omniflight::report
