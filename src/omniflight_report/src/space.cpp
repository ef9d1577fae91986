#include <algorithm>
#include <cmath>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

using Point = std::array<double, 3>;

bool is_finite(const Point& p) {
  return std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); });
}

template <class Items, class Text>
std::string list(const Items& items, const Text& text) {
  std::string out = "[";
  for (const auto& item : items) out += (out.size() == 1 ? "" : ",") + text(item);
  return out + "]";
}

std::string number(double value) {
  const std::string one = json_array(std::array{value});
  return one.substr(1, one.size() - 2);
}

}  // namespace

Result<std::string> render(const Space& space) {
  if (space.path.size() != space.value.size()) return bad_input("path and value must have one length");
  if (space.path.size() < 2) return bad_input("a path needs two points");
  bool finite = std::all_of(space.path.begin(), space.path.end(), is_finite);
  for (const SpaceSolid& s : space.solids)
    finite = finite && is_finite(s.a) && is_finite(s.b) && std::isfinite(s.radius);
  for (const SpaceDisc& d : space.discs)
    finite = finite && is_finite(d.center) && is_finite(d.axis) && std::isfinite(d.radius);
  for (const auto& line : space.lines) finite = finite && is_finite(line[0]) && is_finite(line[1]);
  if (!finite) return bad_input("there is a coordinate that is not finite");
  const auto point = [](const Point& p) { return json_array(p); };
  return "<figure class=\"space\"><figcaption>" + escape_html(space.title) +
         "</figcaption><div class=\"bar-row\"><span class=\"label\">" + escape_html(space.value_label) +
         "</span><span class=\"low\"></span><span class=\"viridis\"></span><span class=\"high\"></span></div>"
         "<div class=\"views\"><div class=\"view\"><canvas style=\"height:440px\" tabindex=\"0\" "
         "role=\"img\" "
         "aria-label=\"" +
         escape_html(space.title) +
         "\"></canvas></div></div><script type=\"application/json\">{\"path\":" + list(space.path, point) +
         ",\"value\":" + json_array(space.value) + ",\"solids\":" +
         list(space.solids,
              [&](const SpaceSolid& s) {
                return std::string("{\"rod\":") + (s.is_rod ? "true" : "false") +
                       ",\"zone\":" + (s.is_zone ? "true" : "false") + ",\"a\":" + point(s.a) +
                       ",\"b\":" + point(s.b) + ",\"radius\":" + number(s.radius) + "}";
              }) +
         ",\"discs\":" +
         list(space.discs,
              [&](const SpaceDisc& d) {
                return "{\"center\":" + point(d.center) + ",\"axis\":" + point(d.axis) +
                       ",\"radius\":" + number(d.radius) + "}";
              }) +
         ",\"lines\":" +
         list(space.lines,
              [&](const auto& line) { return "[" + point(line[0]) + "," + point(line[1]) + "]"; }) +
         "}</script></figure>\n";
}

}  // namespace omniflight::report
