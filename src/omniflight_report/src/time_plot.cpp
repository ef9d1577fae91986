#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "omniflight_report/decimate.hpp"
#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

using Indices = std::vector<std::size_t>;

std::vector<double> picked(const std::vector<double>& values, const Indices& indices) {
  std::vector<double> out;
  out.reserve(values.empty() ? 0 : indices.size());
  if (!values.empty()) {
    for (const std::size_t i : indices) out.push_back(values[i]);
  }
  return out;
}

Indices kept(const Series& series, std::size_t samples) {
  const std::array<std::span<const double>, 3> channels = {series.y, series.low, series.high};
  return kept_samples({channels.data(), series.low.empty() ? std::size_t{1} : std::size_t{3}}, samples);
}

// What a reader must know about the data behind the lines.
std::string notes(const TimePlot& plot, std::size_t samples) {
  std::string out;
  std::size_t most = 0;
  for (const Series& series : plot.series) {
    most = std::max(most, series.y.size());
    const auto gaps =
        std::count_if(series.y.begin(), series.y.end(), [](double v) { return !std::isfinite(v); });
    if (gaps > 0)
      out += escape_html(series.name) + ": " + std::to_string(gaps) + " of " +
             std::to_string(series.y.size()) + " samples are missing or not finite (gaps). ";
  }
  if (most > samples) {
    out += "Thinned from up to " + std::to_string(most) + " samples a line; extremes and gaps are kept.";
  }
  return out.empty() ? "" : "<p class=\"footnote\">" + out + "</p>";
}

std::string series_json(const Series& series, std::size_t samples) {
  const Indices indices = kept(series, samples);
  std::string out =
      "{\"name\":" + json_string(series.name) + ",\"dashed\":" + (series.dashed ? "true" : "false") +
      ",\"points\":" + (series.points ? "true" : "false") +
      ",\"x\":" + json_array(picked(series.x, indices)) + ",\"y\":" + json_array(picked(series.y, indices));
  if (!series.low.empty()) {
    out += ",\"low\":" + json_array(picked(series.low, indices)) +
           ",\"high\":" + json_array(picked(series.high, indices));
  }
  return out + "}";
}

}  // namespace

Status prepare(TimePlot& plot) {
  if (plot.height_px < 80 || plot.height_px > 2000) return bad_input("height_px must be within 80..2000");
  for (Series& series : plot.series) {
    const std::size_t n = series.x.size();
    const bool band = !series.low.empty() || !series.high.empty();
    if (series.y.size() != n || (band && (series.low.size() != n || series.high.size() != n))) {
      return bad_input("series '" + series.name + "' has vectors of different lengths");
    }
    Indices order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t i) { return !std::isfinite(series.x[i]); });
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return series.x[a] < series.x[b]; });
    for (auto* values : {&series.x, &series.y, &series.low, &series.high}) *values = picked(*values, order);
  }
  return {};
}

std::size_t number_count(const TimePlot& plot, std::size_t samples) {
  std::size_t count = 0;
  for (const Series& series : plot.series)
    count += std::min(samples, series.x.size()) * (series.low.empty() ? 2 : 4);
  return count;
}

std::string render(const TimePlot& plot, std::size_t samples) {
  std::string out =
      "<figure class=\"plot\"><figcaption>" + escape_html(plot.title) +
      "</figcaption><div class=\"legend\"></div>" + "<div class=\"ylabel\">" + escape_html(plot.y_label) +
      "</div><div class=\"chart\" style=\"height:" + std::to_string(plot.height_px) +
      "px\"></div><div class=\"xlabel\">" + escape_html(plot.x_label) + "</div>" + notes(plot, samples) +
      "<script type=\"application/json\">{\"group\":" + json_string(plot.group) +
      ",\"x_label\":" + json_string(plot.x_label) + ",\"series\":[";
  for (const Series& series : plot.series) {
    if (out.back() == '}') out += ',';
    out += series_json(series, samples);
  }
  out += "],\"windows\":[";
  for (const Window& window : plot.windows) {
    if (!std::isfinite(window.from) || !std::isfinite(window.to)) continue;
    if (out.back() == '}') out += ',';
    const std::array<double, 2> ends = {window.from, window.to};
    out += "{\"ends\":" + json_array(ends) + ",\"label\":" + json_string(window.label) + ",\"tone\":\"" +
           tone_class(window.tone) + "\"}";
  }
  return out + "]}</script></figure>\n";
}

}  // namespace omniflight::report
