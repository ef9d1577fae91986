// Logs of rotorcraft-genom3 (telekyb3): text, a header of names and one sample a line, separated by blanks.
#include <algorithm>
#include <cmath>

#include "csv_cells.hpp"
#include "csv_table.hpp"
#include "format_table.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

/// Rows are written at the rate of the component, sensors and rotors are measured less often; in between
/// their last values stand in the log. What stands still for longer than this is a measurement again.
constexpr double kHeld_s = 0.1;

bool is_genom3(std::string_view head) {
  const std::string_view line = head.substr(0, head.find('\n'));
  return line.substr(0, 3) == "ts " && line.find(" imu_wx ") != std::string_view::npos &&
         line.find(" cmd_v0 ") != std::string_view::npos && line.size() < head.size();
}

int column_of(const std::vector<std::string>& header, const std::string& name) {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

std::vector<int> numbered(const std::vector<std::string>& header, const std::string& before) {
  std::vector<int> out;
  for (int column = 0; (column = column_of(header, before + std::to_string(out.size()))) >= 0;)
    out.push_back(column);
  return out;
}

/// Rotors that turn or are told to in some row. The log has a fixed number of columns; those of rotors that
/// the vehicle does not have are zero or nan.
std::size_t rotors_in_use(std::string_view bytes, const std::vector<int>& commanded,
                          const std::vector<int>& measured) {
  std::size_t rotors = 0;
  std::vector<std::string_view> cells;
  for (std::size_t at = bytes.find('\n'); at < bytes.size();) {
    const auto end = std::min(bytes.find('\n', at + 1), bytes.size());
    split_row(bytes.substr(at + 1, end - at - 1), ' ', cells);
    at = end;
    for (const auto* columns : {&commanded, &measured})
      for (std::size_t i = columns->size(); i > rotors; --i) {
        const auto column = static_cast<std::size_t>((*columns)[i - 1]);
        double value = 0;
        if (column >= cells.size() || parse_cell(cells[column], false, value) != Cell::number || value == 0)
          continue;
        rotors = i;
      }
    if (rotors == commanded.size() && rotors == measured.size()) break;
  }
  return rotors;
}

void add(CsvLayout& layout, const char* name, std::vector<int> columns, double scale, double held_s) {
  if (columns.empty() || std::count(columns.begin(), columns.end(), -1) > 0) return;
  CsvSignal signal;
  signal.signal = name;
  signal.unit = find_spec(name)->unit;
  signal.columns = std::move(columns);
  signal.scale = scale;
  signal.held_s = held_s;
  layout.signals.push_back(std::move(signal));
}

Result<Recording> read_genom3(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  CsvTable table(bytes, file);
  const auto header = table.header(' ');
  if (!header) return Failure(header.error());
  auto commanded = numbered(*header, "cmd_v"), measured = numbered(*header, "meas_v");
  const std::size_t rotors = rotors_in_use(bytes, commanded, measured);
  commanded.resize(std::min(commanded.size(), rotors));
  measured.resize(std::min(measured.size(), rotors));

  CsvLayout layout;
  layout.time_column = 0;
  const auto three = [&](const std::string& before) {
    return std::vector<int>{column_of(*header, before + "x"), column_of(*header, before + "y"),
                            column_of(*header, before + "z")};
  };
  constexpr double kTurn = 2 * kPi;  // rotor speeds are in rev/s
  add(layout, "gyro", three("imu_w"), 1.0, kHeld_s);
  add(layout, "acc", three("imu_a"), 1.0, kHeld_s);
  add(layout, "rotor_command", commanded, kTurn, 0.0);
  add(layout, "rotor_speed", measured, kTurn, kHeld_s);

  Recording recording;
  if (!options.map.empty())
    recording.note(Note::Kind::ignored, "the map was not used: the columns of this format are known");
  if (const auto ok = table.rows(layout, recording); !ok) return Failure(ok.error());
  if (table.blank_rows() > 0)
    recording.note(Note::Kind::loss,
                   "the logger could not keep up " + std::to_string(table.blank_rows()) +
                       " times (empty lines); samples are missing there",
                   table.blank_rows());
  recording.note(Note::Kind::information,
                 "times are those of writing, not of measuring; pose and reference are in the logs of other "
                 "components, which are not read");
  return recording;
}

}  // namespace

const Format& genom3_format() {
  static const Format format{"genom3", "rotorcraft-genom3 (telekyb3)", is_genom3, read_genom3};
  return format;
}

}  // namespace omniflight::recording
