#include <algorithm>
#include <array>
#include <cmath>

#include "omniflight_report/decimate.hpp"
#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

std::string json_of(const char* key, const std::vector<double>& values,
                    const std::vector<std::size_t>& indices) {
  std::vector<double> kept;
  if (!values.empty()) {
    for (const std::size_t i : indices) kept.push_back(values[i]);
  }
  return "\"" + std::string(key) + "\":" + json_array(kept);
}

std::size_t kept_count(std::size_t n, std::size_t samples) { return std::min(n, samples); }

}  // namespace

Status prepare(PathPlot& plot) {
  if (plot.height_px < 80 || plot.height_px > 2000) return bad_input("height_px must be within 80..2000");
  const std::size_t n = plot.x.size();
  if (plot.y.size() != n || plot.z.size() != n || plot.value.size() != n ||
      (!plot.t.empty() && plot.t.size() != n)) {
    return bad_input("x, y, z, value (and t) must have one length");
  }
  if (plot.reference_y.size() != plot.reference_x.size() ||
      plot.reference_z.size() != plot.reference_x.size()) {
    return bad_input("reference_x, _y and _z must have one length");
  }
  // A position is known in all three coordinates or it is a gap.
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(plot.x[i]) || !std::isfinite(plot.y[i]) || !std::isfinite(plot.z[i]))
      plot.x[i] = std::nan("");
  }
  return {};
}

std::size_t number_count(const PathPlot& plot, std::size_t samples) {
  return (plot.t.empty() ? 4 : 5) * kept_count(plot.x.size(), samples) +
         3 * kept_count(plot.reference_x.size(), samples);
}

std::string render(const PathPlot& plot, std::size_t samples) {
  const std::array<std::span<const double>, 4> channels = {plot.x, plot.y, plot.z, plot.value};
  const auto indices = kept_samples(channels, samples);
  const std::array<std::span<const double>, 3> reference = {plot.reference_x, plot.reference_y,
                                                            plot.reference_z};
  const auto reference_indices = kept_samples(reference, samples);
  const std::string height = "style=\"height:" + std::to_string(plot.height_px) + "px\"";
  return "<figure class=\"path\"><figcaption>" + escape_html(plot.title) +
         "</figcaption><div class=\"bar-row\"><span class=\"label\">" + escape_html(plot.value_label) +
         "</span><span class=\"low\"></span><span class=\"viridis\"></span><span class=\"high\"></span>" +
         "<span class=\"readout\"></span></div><div class=\"views\"><div class=\"view\" data-across=\"x\" "
         "data-up=\"y\"><p>from above: x [m] "
         "\u2192, y [m] \u2191</p><canvas " +
         height +
         "></canvas></div><div class=\"view\" data-across=\"x\" data-up=\"z\"><p>from the side: x [m] "
         "\u2192, z [m] \u2191</p><canvas " +
         height + "></canvas></div></div><script type=\"application/json\">{" +
         json_of("x", plot.x, indices) + "," + json_of("y", plot.y, indices) + "," +
         json_of("z", plot.z, indices) + "," + json_of("v", plot.value, indices) + "," +
         json_of("t", plot.t, indices) + ",\"label\":" + json_string(plot.value_label) + ",\"reference\":{" +
         json_of("x", plot.reference_x, reference_indices) + "," +
         json_of("y", plot.reference_y, reference_indices) + "," +
         json_of("z", plot.reference_z, reference_indices) + "}}</script></figure>\n";
}

}  // namespace omniflight::report
