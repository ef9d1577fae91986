#include <algorithm>
#include <cmath>
#include <cstdio>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f%%",
                100.0 * std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0));
  return text;
}

std::string line(double share, const char* kind) {
  const std::string at = percent(share);
  return "<line class=\"" + std::string(kind) + "\" x1=\"" + at + "\" x2=\"" + at +
         "\" y1=\"0\" y2=\"100%\"/>";
}

}  // namespace

Result<std::string> render(const Bars& bars) {
  double full = bars.full;
  for (const Bar& bar : bars.bars) {
    if (bar.value < 0.0) return bad_input("bar '" + bar.name + "' is negative");
    if (bars.full > 0.0) continue;
    for (const double v : {bar.value, bar.high.value_or(0.0)}) {
      if (std::isfinite(v)) full = std::max(full, v);
    }
  }
  if (!(full > 0.0) || !std::isfinite(full)) full = 1.0;
  const std::string unit =
      bars.unit.empty() ? "" : " <span class=\"unit\">" + escape_html(bars.unit) + "</span>";
  std::string out =
      "<figure class=\"bars\"><figcaption>" + escape_html(bars.title) + "</figcaption><div class=\"grid\">";
  for (const Bar& bar : bars.bars) {
    const std::string name = escape_html(bar.name);
    out += "<div class=\"name\" title=\"" + name + "\">" + name +
           "</div><svg height=\"18\" aria-hidden=\"true\">";
    out +=
        "<rect class=\"track\" width=\"100%\" height=\"100%\" rx=\"3\"/><rect class=\"bar\" height=\"100%\" "
        "rx=\"3\" width=\"" +
        percent(bar.value / full) + "\"/>";
    if (bar.low && bar.high) {
      out += "<line class=\"whisker\" x1=\"" + percent(*bar.low / full) + "\" x2=\"" +
             percent(*bar.high / full) + "\" y1=\"50%\" y2=\"50%\"/>" + line(*bar.low / full, "whisker") +
             line(*bar.high / full, "whisker");
    }
    if (bars.marker) out += line(*bars.marker / full, "marker");
    out += "</svg><div class=\"value\">" + number_html(bar.value, 3) + unit;
    if (!bar.note.empty()) out += " <span class=\"note\">" + escape_html(bar.note) + "</span>";
    out += "</div>";
  }
  out += "</div>";
  if (bars.marker) {
    out += "<p class=\"footnote\"><span class=\"dash\"></span>" + escape_html(bars.marker_label) + " (" +
           number_html(*bars.marker, 3) + unit + ")</p>";
  }
  return out + "</figure>\n";
}

}  // namespace omniflight::report
