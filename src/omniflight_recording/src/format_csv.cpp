// Canonical CSV, and foreign CSV through a map.
#include "csv_cells.hpp"
#include "csv_table.hpp"
#include "format_table.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

bool is_csv(std::string_view head) {
  const std::string_view line = head.substr(0, head.find('\n'));
  const char separator = separator_of(line);
  if (separator == '\0' || head.find('\n') == std::string_view::npos) return false;
  for (const char c : line)
    if ((static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r') || c == 0x7f) return false;
  double number;
  return parse_cell(trimmed(line.substr(0, line.find(separator))), true, number) ==
         Cell::bad;  // a header, not a number
}

Result<Recording> read_csv(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  if (bytes.substr(0, 3) == "\xef\xbb\xbf") bytes.remove_prefix(3);
  CsvTable table(bytes, file);
  const auto header = table.header();
  if (!header) return Failure(header.error());
  const auto layout = layout_of(*header, file, options.map);
  if (!layout) return Failure(layout.error());
  Recording recording;
  if (!layout->found_map.empty())
    recording.note(Note::Kind::information,
                   "its columns were read as the map " + layout->found_map.stem().string() + " says");
  for (const auto& name : layout->ignored)
    recording.note(Note::Kind::ignored, "column " + files::shown(name) + " has no known meaning");
  if (const auto ok = table.rows(*layout, recording); !ok) return Failure(ok.error());
  return recording;
}

}  // namespace

const Format& csv_format() {
  static const Format format{"csv", "canonical CSV, or any CSV with a map", is_csv, read_csv};
  return format;
}

}  // namespace omniflight::recording
