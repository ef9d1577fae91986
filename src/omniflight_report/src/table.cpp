#include <algorithm>
#include <cmath>

#include "omniflight_report/escape.hpp"
#include "render.hpp"

namespace omniflight::report {
namespace {

// A whole-number column is printed without decimals (counts, indices).
bool whole_numbers(const Table& table, std::size_t column) {
  return std::all_of(table.rows.begin(), table.rows.end(), [&](const auto& row) {
    const auto* number = std::get_if<double>(&row[column].value);
    return number == nullptr || !std::isfinite(*number) ||
           (*number == std::round(*number) && std::abs(*number) < 1e6);
  });
}

bool has_numbers(const Table& table, std::size_t column) {
  return std::any_of(table.rows.begin(), table.rows.end(),
                     [&](const auto& row) { return std::holds_alternative<double>(row[column].value); });
}

std::string colour(const Cell& cell) {
  if (!cell.ratio || std::isnan(*cell.ratio) || *cell.ratio < 0.0) return {};
  const double octaves = std::clamp(std::log2(std::max(*cell.ratio, 1e-9)), -1.0, 1.0);
  const int percent = static_cast<int>(std::lround(45.0 * std::abs(octaves)));
  if (percent == 0) return {};
  return std::string(" heat ") + (octaves < 0 ? "better" : "worse") +
         "\" style=\"--a:" + std::to_string(percent) + "%";
}

}  // namespace

Result<std::string> render(const Table& table) {
  if (table.columns.empty()) return bad_input("a table needs at least one column");
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (table.rows[r].size() != table.columns.size()) {
      return bad_input("row " + std::to_string(r) + " has " + std::to_string(table.rows[r].size()) +
                       " cells for " + std::to_string(table.columns.size()) + " columns");
    }
  }
  std::vector<std::string> classes;
  std::vector<bool> whole;
  const bool wide = table.columns.size() > 3;  // on a phone's screen a row becomes a block of labelled lines
  std::string out = wide ? "<figure class=\"table wide\">" : "<figure class=\"table\">";
  if (!table.caption.empty()) out += "<figcaption>" + escape_html(table.caption) + "</figcaption>";
  out += "<div class=\"scroll\"><table><thead><tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const Column& column = table.columns[c];
    const bool right =
        column.align == Align::right || (column.align == Align::automatic && has_numbers(table, c));
    classes.emplace_back(right ? "right" : "left");
    whole.push_back(whole_numbers(table, c));
    out += "<th scope=\"col\" class=\"" + classes.back() + "\">" + escape_html(column.name);
    if (!column.unit.empty()) out += " <span class=\"unit\">[" + escape_html(column.unit) + "]</span>";
    out += "</th>";
  }
  out += "</tr></thead><tbody>";
  for (const auto& row : table.rows) {
    out += "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c) {
      const auto* number = std::get_if<double>(&row[c].value);
      const Column& column = table.columns[c];
      out += "<td class=\"" + classes[c] + colour(row[c]) + "\"";
      if (wide)
        out += " data-label=\"" + escape_html(column.name) +
               (column.unit.empty() ? "" : " [" + escape_html(column.unit) + "]") + "\"";
      out += ">";
      if (number == nullptr) {
        const auto& text = std::get<std::string>(row[c].value);
        out += column.symbols ? symbol_html(text) : escape_html(text);
      } else if (whole[c] && std::isfinite(*number)) {
        out += std::to_string(static_cast<long>(*number));
      } else {
        out += number_html(*number, table.columns[c].significant_digits);
      }
      out += "</td>";
    }
    out += "</tr>";
  }
  return out + "</tbody></table></div></figure>\n";
}

}  // namespace omniflight::report
