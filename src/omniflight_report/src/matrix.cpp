#include <algorithm>
#include <cmath>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

std::string heat_cell(double value, double largest, bool numbers) {
  if (!std::isfinite(value)) return "<td>" + number_html(value) + "</td>";
  const int percent = static_cast<int>(std::lround(80.0 * std::abs(value) / largest));
  const std::string text = number_html(value, 2);
  return std::string("<td class=\"heat ") + (value < 0 ? "worse" : "better") +
         "\" style=\"--a:" + std::to_string(percent) + "%\" title=\"" + text.substr(0, text.find('<')) +
         "\">" + (numbers ? text : "") + "</td>";
}

}  // namespace

Result<std::string> render(const Matrix& matrix) {
  if (matrix.values.size() != matrix.rows.size()) {
    return bad_input(std::to_string(matrix.values.size()) + " rows of values for " +
                     std::to_string(matrix.rows.size()) + " labels");
  }
  double largest = 0.0;
  bool negative = false;
  for (const auto& row : matrix.values) {
    if (row.size() != matrix.columns.size()) {
      return bad_input("a row of " + std::to_string(row.size()) + " values for " +
                       std::to_string(matrix.columns.size()) + " column labels");
    }
    for (const double v : row) {
      if (!std::isfinite(v)) continue;
      largest = std::max(largest, std::abs(v));
      negative = negative || v < 0.0;
    }
  }
  if (largest == 0.0) largest = 1.0;
  const bool numbers = matrix.columns.size() <= 24;
  std::string out = "<figure class=\"matrix\"><figcaption>" + escape_html(matrix.title) +
                    "</figcaption><div class=\"scroll\"><table><thead>";
  if (!matrix.column_title.empty()) {
    out += "<tr><td></td><th class=\"axis\" colspan=\"" + std::to_string(matrix.columns.size()) + "\">" +
           escape_html(matrix.column_title) + "</th></tr>";
  }
  out += "<tr><th class=\"axis corner\">" + escape_html(matrix.row_title) + "</th>";
  for (const auto& label : matrix.columns)
    out += "<th scope=\"col\"><span>" + escape_html(label) + "</span></th>";
  out += "</tr></thead><tbody>";
  for (std::size_t r = 0; r < matrix.rows.size(); ++r) {
    out += "<tr><th scope=\"row\">" + escape_html(matrix.rows[r]) + "</th>";
    for (const double v : matrix.values[r]) out += heat_cell(v, largest, numbers);
    out += "</tr>";
  }
  out += "</tbody></table></div><p class=\"footnote scale\">" + escape_html(matrix.value_label) + ": ";
  out += negative ? number_html(-largest, 2) + " <span class=\"ramp both\"></span> "
                  : "0 <span class=\"ramp\"></span> ";
  return out + number_html(largest, 2) + "</p></figure>\n";
}

}  // namespace omniflight::report
