#include "csv_cells.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace omniflight::recording {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view without_blanks(std::string_view s) {
  while (!s.empty() && is_blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && is_blank(s.back())) s.remove_suffix(1);
  return s;
}

/// Where the cell that begins at `at` ends: the next separator outside quotes, or the end of the row. A quote
/// only opens a cell at its beginning; one that is never closed is text.
std::size_t end_of_cell(std::string_view row, std::size_t at, char separator) {
  const auto first = row.find_first_not_of(separator == '\t' ? " " : " \t", at);
  if (first != std::string_view::npos && row[first] == '"')
    for (auto quote = row.find('"', first + 1); quote != std::string_view::npos;
         quote = row.find('"', quote + 1)) {
      const auto next = row.find_first_not_of(separator == '\t' ? " \r" : " \t\r", quote + 1);
      if (next == std::string_view::npos) return row.size();
      if (row[next] == separator) return next;
    }
  return std::min(row.find(separator, at), row.size());
}

void split_at_blanks(std::string_view row, std::vector<std::string_view>& cells) {
  row = without_blanks(row);
  while (!row.empty() && cells.size() <= kMaxColumns) {
    const auto end = std::min(row.find_first_of(" \t"), row.size());
    cells.push_back(row.substr(0, end));
    row = without_blanks(row.substr(end));
  }
}

}  // namespace

std::string_view trimmed(std::string_view s) {
  s = without_blanks(s);
  if (s.size() >= 2 && s.front() == '"' && s.back() == '"') s = s.substr(1, s.size() - 2);
  return s;
}

char separator_of(std::string_view header) {
  const auto count = [&](char c) { return std::count(header.begin(), header.end(), c); };
  const auto commas = count(','), semicolons = count(';'), tabs = count('\t');
  if (semicolons > commas && semicolons >= tabs) return ';';
  if (tabs > commas) return '\t';
  return commas > 0 ? ',' : '\0';
}

void split_row(std::string_view row, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  if (separator == ' ') return split_at_blanks(row, cells);
  for (std::size_t at = 0; cells.size() <= kMaxColumns;) {
    const auto end = end_of_cell(row, at, separator);
    cells.push_back(trimmed(row.substr(at, end - at)));
    if (end == row.size()) break;
    at = end + 1;
  }
}

Cell parse_cell(std::string_view text, bool decimal_commas, double& value) {
  if (text.empty()) return Cell::empty;
  if (text[0] == '+') text.remove_prefix(1);
  std::array<char, 64> pointed{};
  const auto comma = decimal_commas ? text.find(',') : std::string_view::npos;
  if (comma != std::string_view::npos) {
    if (text.size() > pointed.size() || text.find('.') != std::string_view::npos) return Cell::bad;
    std::copy(text.begin(), text.end(), pointed.begin());
    pointed[comma] = '.';
    text = std::string_view(pointed.data(), text.size());
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error != std::errc()) return Cell::bad;
  if (std::isnan(value)) return Cell::empty;  // many exporters write nan for "no sample"
  if (!std::isfinite(value)) return Cell::bad;
  return comma != std::string_view::npos ? Cell::comma : Cell::number;
}

Cell parse_list(std::string_view text, std::vector<double>& values) {
  text = trimmed(text);
  if (text.size() >= 2 && (text.front() == '[' || text.front() == '(')) {
    if (text.back() != (text.front() == '[' ? ']' : ')')) return Cell::bad;
    text = text.substr(1, text.size() - 2);
  }
  std::size_t listed = 0;
  constexpr const char* kBetween = ",; \t";
  for (auto at = text.find_first_not_of(kBetween); at != std::string_view::npos; ++listed) {
    const auto end = std::min(text.find_first_of(kBetween, at), text.size());
    double value = 0;
    if (listed == kMaxListed || parse_cell(text.substr(at, end - at), false, value) != Cell::number)
      return Cell::bad;
    values.push_back(value);
    at = text.find_first_not_of(kBetween, end);
  }
  return listed > 0 ? Cell::number : Cell::empty;
}

}  // namespace omniflight::recording
