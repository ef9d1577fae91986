#include <algorithm>
#include <cmath>
#include <cstdio>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

constexpr double kSide = 380, kMargin = 26;  // of a view, in units of its drawing
constexpr std::size_t kColours = 8;          // --s0 ... --s7 of the style sheet

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// From the unit of the labels to the drawing: x to the right, y up.
struct Scale {
  double largest;
  double at(double value) const {
    return kSide / 2 + (kSide / 2 - kMargin) * std::clamp(value / largest, -1.0, 1.0);
  }
  std::string point(const std::pair<double, double>& p) const {
    return number(at(p.first)) + "," + number(at(-p.second));
  }
};

std::string colour(std::size_t k) { return "--k:var(--s" + std::to_string(k % kColours) + ")"; }

std::string view_svg(const OutlineView& view, const Outlines& all, const Scale& scale) {
  const std::string side = number(kSide), middle = number(kSide / 2), end = number(kSide - kMargin),
                    begin = number(kMargin);
  std::string names;
  for (const Outline& o : view.outlines) names += (names.empty() ? "" : ", ") + o.name;
  std::string out = "<div class=\"view\"><svg viewBox=\"0 0 " + side + " " + side +
                    "\" role=\"img\" aria-label=\"" +
                    escape_html(view.x_label + " and " + view.y_label + ": " + names) + "\">";
  out += "<rect class=\"frame\" x=\".5\" y=\".5\" width=\"" + number(kSide - 1) + "\" height=\"" +
         number(kSide - 1) + "\" rx=\"8\"/>";
  out += "<path class=\"axis\" d=\"M" + begin + " " + middle + "H" + end + "M" + middle + " " + begin + "V" +
         end + "\"/>";
  for (std::size_t k = 0; k < view.outlines.size(); ++k) {
    std::string points;
    for (const auto& p : view.outlines[k].points) points += (points.empty() ? "" : " ") + scale.point(p);
    out += "<polygon class=\"shape\" style=\"" + colour(k) + "\" points=\"" + points + "\"><title>" +
           escape_html(view.outlines[k].name) + "</title></polygon>";
  }
  if (all.circle > 0)
    out += "<circle class=\"limit\" cx=\"" + middle + "\" cy=\"" + middle + "\" r=\"" +
           number(scale.at(all.circle) - kSide / 2) + "\"/>";
  out += "<text x=\"" + end + "\" y=\"" + number(kSide / 2 - 7) + "\" text-anchor=\"end\">" +
         escape_html(view.x_label) + "</text><text x=\"" + number(kSide / 2 + 7) + "\" y=\"" +
         number(kMargin - 8) + "\">" + escape_html(view.y_label) + "</text>";
  out += "<text x=\"" + end + "\" y=\"" + number(kSide / 2 + 17) + "\" text-anchor=\"end\">" +
         short_number(scale.largest) + "</text>";
  return out + "</svg></div>";
}

}  // namespace

Result<std::string> render(const Outlines& outlines) {
  if (outlines.views.empty()) return bad_input("outlines need at least one view");
  Scale scale{std::isfinite(outlines.circle) ? outlines.circle : 0.0};
  for (const OutlineView& view : outlines.views) {
    if (view.outlines.size() != outlines.views.front().outlines.size())
      return bad_input("the views have different numbers of outlines");
    for (const Outline& o : view.outlines) {
      if (o.points.size() < 3) return bad_input("outline '" + o.name + "' has less than 3 points");
      for (const auto& [x, y] : o.points) {
        if (!std::isfinite(x) || !std::isfinite(y))
          return bad_input("outline '" + o.name + "' has a point that is not finite");
        scale.largest = std::max({scale.largest, std::abs(x), std::abs(y)});
      }
    }
  }
  if (!(scale.largest > 0)) scale.largest = 1;
  std::string out = "<figure class=\"outlines\"><figcaption>" + escape_html(outlines.title) +
                    "</figcaption><div class=\"views\">";
  for (const OutlineView& view : outlines.views) out += view_svg(view, outlines, scale);
  out += "</div><div class=\"legend\">";
  const auto& named = outlines.views.front().outlines;
  for (std::size_t k = 0; k < named.size(); ++k)
    out +=
        "<span class=\"static\" style=\"" + colour(k) + "\"><i></i>" + escape_html(named[k].name) + "</span>";
  if (outlines.circle > 0)
    out += "<span class=\"static\"><span class=\"dash\"></span>" + escape_html(outlines.circle_label) +
           "</span>";
  return out + "</div></figure>\n";
}

}  // namespace omniflight::report
