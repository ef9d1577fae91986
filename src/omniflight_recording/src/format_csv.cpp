// Canonical CSV, and foreign CSV through a map.
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "collector.hpp"
#include "csv_map.hpp"
#include "format_table.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

constexpr std::size_t kMaxColumns = 2000, kMaxLine = 1u << 20;

std::string_view trimmed(std::string_view s) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  if (s.size() >= 2 && s.front() == '"' && s.back() == '"') s = s.substr(1, s.size() - 2);
  return s;
}

void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t at = 0; cells.size() <= kMaxColumns;) {
    const auto comma = line.find(',', at);
    cells.push_back(trimmed(line.substr(at, comma == std::string_view::npos ? comma : comma - at)));
    if (comma == std::string_view::npos) break;
    at = comma + 1;
  }
}

enum class Cell { empty, number, bad };
Cell parse(std::string_view text, double& value) {
  if (text.empty()) return Cell::empty;
  if (text[0] == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error != std::errc()) return Cell::bad;
  if (std::isnan(value)) return Cell::empty;  // many exporters write nan for "no sample"
  return std::isfinite(value) ? Cell::number : Cell::bad;
}

bool is_csv(std::string_view head) {
  const std::string_view line = head.substr(0, head.find('\n'));
  if (line.empty() || line.find(',') == std::string_view::npos || head.find('\n') == std::string_view::npos)
    return false;
  for (const char c : line)
    if ((static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r') || c == 0x7f) return false;
  double number;
  return parse(trimmed(line.substr(0, line.find(','))), number) == Cell::bad;  // a header, not a number
}

Result<Recording> read_csv(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  if (bytes.substr(0, 3) == "\xef\xbb\xbf") bytes.remove_prefix(3);
  std::size_t line_number = 0, at = 0;
  bool last_line_whole = true;
  const auto next_line = [&](std::string_view& line) {
    if (at >= bytes.size()) return false;
    const auto end = bytes.find('\n', at);
    last_line_whole = end != std::string_view::npos;
    line = bytes.substr(at, last_line_whole ? end - at : std::string_view::npos);
    at = last_line_whole ? end + 1 : bytes.size();
    ++line_number;
    return true;
  };
  const auto here = [&] { return file + ":" + std::to_string(line_number); };

  std::string_view line;
  std::vector<std::string_view> cells;
  if (!next_line(line)) return bad_input("is empty", file, "Give a CSV with a header row");
  if (line.size() > kMaxLine) return bad_input("the header is longer than 1 MB", here());
  if (line.substr(0, 1) == "#") line.remove_prefix(1);
  split(line, cells);
  if (cells.size() > kMaxColumns)
    return bad_input("has more than 2000 columns", here(), "Export fewer columns");
  const std::vector<std::string> header(cells.begin(), cells.end());
  auto layout = layout_of(header, file, options.map);
  if (!layout) return Failure(layout.error());

  Recording recording;
  Collector collector;
  if (!layout->found_map.empty())
    recording.note(Note::Kind::information,
                   "its columns were read as the map " + layout->found_map.stem().string() + " says");
  for (const auto& name : layout->ignored)
    recording.note(Note::Kind::ignored, "column " + files::shown(name) + " has no known meaning");
  for (const auto& s : layout->signals)
    collector.describe(s.signal, s.unit, "column " + header[static_cast<std::size_t>(s.columns.front())]);
  struct Rejected {
    std::uint64_t partial = 0;
    std::size_t first_line = 0;
  };
  std::vector<Rejected> rejected(layout->signals.size());
  std::vector<double> values;
  double start = 0.0, previous = -std::numeric_limits<double>::infinity();
  bool first = true;
  while (next_line(line)) {
    if (trimmed(line).empty()) continue;
    if (line.size() > kMaxLine)
      return bad_input("a row is longer than 1 MB", here(), "This is not a CSV of samples");
    split(line, cells);
    if (cells.size() != header.size()) {
      if (!last_line_whole) {
        recording.note(Note::Kind::loss, "the last row is cut off and was left out", 1);
        break;
      }
      return bad_input(
          "has " + std::to_string(cells.size()) + " cells, the header has " + std::to_string(header.size()),
          here(), "Repair the row");
    }
    double t = 0;
    if (parse(cells[static_cast<std::size_t>(layout->time_column)], t) != Cell::number)
      return bad_input("time " + files::shown(cells[static_cast<std::size_t>(layout->time_column)]) +
                           " is not a finite number",
                       here() + ": " + header[static_cast<std::size_t>(layout->time_column)],
                       "Repair the row");
    if (first) recording.start_s = std::abs(t * layout->time_scale) > 1e6 ? t * layout->time_scale : 0.0;
    if (first) start = recording.start_s > 0 ? t : 0.0;
    first = false;
    t = (t - start) * layout->time_scale;
    if (t < previous)
      return bad_input(
          "time runs backwards, from " + std::to_string(previous) + " s to " + std::to_string(t) + " s",
          here(), "Sort the rows, or split the file where the clock was reset");
    previous = t;
    for (std::size_t k = 0; k < layout->signals.size(); ++k) {
      const CsvSignal& s = layout->signals[k];
      values.clear();
      for (const int column : s.columns) {
        double value = 0;
        const auto& cell = cells[static_cast<std::size_t>(column)];
        const Cell kind = parse(cell, value);
        if (kind == Cell::bad && !last_line_whole) continue;  // a number cut in the middle
        if (kind == Cell::bad)
          return bad_input(files::shown(cell) + " is not a finite number",
                           here() + ": " + header[static_cast<std::size_t>(column)],
                           "Correct the cell or leave it empty");
        if (kind == Cell::number) values.push_back(value * s.scale + s.offset);
      }
      if (values.size() == s.columns.size()) {
        collector.add(s.signal, t, values.data(), values.size());
      } else if (!values.empty() && rejected[k].partial++ == 0) {
        rejected[k].first_line = line_number;
      }
    }
  }
  if (!last_line_whole)
    recording.note(Note::Kind::loss, "the file does not end with a line break; its last row may be cut");
  for (std::size_t k = 0; k < rejected.size(); ++k)
    if (rejected[k].partial > 0)
      recording.note(Note::Kind::ignored,
                     layout->signals[k].signal + ": " + std::to_string(rejected[k].partial) +
                         " rows have only some of its cells (first in line " +
                         std::to_string(rejected[k].first_line) + ") and were left out",
                     rejected[k].partial);
  collector.finish(recording);
  if (recording.signal_names().empty())
    return bad_input("contains no sample of any known signal", file, "Describe its columns with --map FILE");
  return recording;
}

}  // namespace

const Format& csv_format() {
  static const Format format{"csv", "canonical CSV, or any CSV with a map", is_csv, read_csv};
  return format;
}

}  // namespace omniflight::recording
