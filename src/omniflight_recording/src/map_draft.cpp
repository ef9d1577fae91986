#include "omniflight_recording/map_draft.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "column_groups.hpp"
#include "csv_cells.hpp"
#include "format_table.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

constexpr std::size_t kRows = 20000;  // that are looked at

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  double first = 0, last = 0;
  std::size_t numbers = 0;
  double mean_step() const { return numbers > 1 ? (last - first) / static_cast<double>(numbers - 1) : 0.0; }
  double size() const { return numbers > 0 ? std::max(std::abs(low), std::abs(high)) : 0.0; }
};

struct Table {
  std::vector<std::string> header;
  std::vector<Range> ranges;
};

/// The last word of a group's names, and what it stands for.
struct Meaning {
  char kind;
  const char* word;
  const char* signal;
};
constexpr Meaning kMeanings[] = {{'v', "", "position"},
                                 {'v', "p", "position"},
                                 {'v', "pos", "position"},
                                 {'v', "position", "position"},
                                 {'v', "v", "velocity"},
                                 {'v', "vel", "velocity"},
                                 {'v', "velocity", "velocity"},
                                 {'v', "gyro", "gyro"},
                                 {'v', "gyr", "gyro"},
                                 {'v', "w", "gyro"},
                                 {'v', "omega", "gyro"},
                                 {'v', "acc", "acc"},
                                 {'v', "accel", "acc"},
                                 {'v', "a", "acc"},
                                 {'v', "accelerometer", "acc"},
                                 {'q', "q", "attitude"},
                                 {'q', "quat", "attitude"},
                                 {'q', "quaternion", "attitude"},
                                 {'q', "orientation", "attitude"},
                                 {'q', "attitude", "attitude"},
                                 {'n', "rpm", "rotor_speed"},
                                 {'n', "rotor", "rotor_speed"},
                                 {'n', "omega", "rotor_speed"},
                                 {'n', "pwm", "pwm"},
                                 {'n', "motor", "pwm"},
                                 {'n', "m", "pwm"},
                                 {'s', "vbat", "vbat"},
                                 {'s', "voltage", "vbat"},
                                 {'s', "volt", "vbat"},
                                 {'s', "battery", "vbat"},
                                 {'s', "ibat", "ibat"},
                                 {'s', "current", "ibat"}};

const char* meaning_of(const ColumnGroup& group) {
  const std::string word = group.words.empty() ? "" : group.words.back();
  for (const Meaning& m : kMeanings)
    if (m.kind == group.kind && word == m.word) return m.signal;
  return nullptr;
}

struct Scale {
  double factor = 1.0, offset = 0.0;
  std::string why;  // empty: taken as SI, because nothing says otherwise
};

Scale scale_of(const std::string& signal, const ColumnGroup& group, double size) {
  const std::string& unit = group.unit;
  const bool rpm =
      unit == "rpm" || unit == "rev/min" || (!group.words.empty() && group.words.back() == "rpm");
  if (signal == "rotor_speed" && rpm) return {kPi / 30, 0, "rev/min by its name"};
  if (unit.rfind("deg", 0) == 0 || unit.rfind("\xc2\xb0", 0) == 0)
    return {kPi / 180, 0, "degrees by its name"};
  if (unit == "mm") return {1e-3, 0, "mm by its name"};
  if (unit == "cm" || unit == "cm/s") return {1e-2, 0, "cm by its name"};
  if (signal == "acc" && unit == "g") return {kGravity, 0, "g by its name"};
  if (signal == "acc" && unit.empty() && size > 0.5 && size < 5) return {kGravity, 0, "g by its size"};
  if (signal == "vbat" && unit == "mv") return {1e-3, 0, "mV by its name"};
  if (signal == "vbat" && unit.empty() && size > 1000) return {1e-3, 0, "mV by its size"};
  if (signal == "pwm" && size > 800 && size <= 2200)
    return {1e-3, -1, "pulses of 1000 to 2000 us by its size"};
  if (signal == "pwm" && size > 2200) return {1.0 / 65535, 0, "16 bits by its size"};
  if (signal == "pwm" && size > 2) return {1e-2, 0, "percent by its size"};
  return {};
}

std::string text_of(double value) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// Whether a YAML file can hold the name: UTF-8 without control characters.
bool is_text(const std::string& name) {
  for (std::size_t i = 0; i < name.size();) {
    const auto c = static_cast<unsigned char>(name[i]);
    const std::size_t more = c < 0x80 ? 0 : c >= 0xc2 && c < 0xe0 ? 1 : c >= 0xe0 && c < 0xf0 ? 2 : 3;
    if (c < 0x20 || c == 0x7f || (c >= 0x80 && c < 0xc2) || c >= 0xf5 || i + more >= name.size())
      return false;
    for (std::size_t k = 1; k <= more; ++k)
      if ((static_cast<unsigned char>(name[i + k]) & 0xc0) != 0x80) return false;
    const auto next = more > 0 ? static_cast<unsigned char>(name[i + 1]) : 0;
    // overlong, surrogates, beyond Unicode, and the control characters behind ASCII
    if ((c == 0xe0 && next < 0xa0) || (c == 0xed && next > 0x9f) || (c == 0xf0 && next < 0x90) ||
        (c == 0xf4 && next > 0x8f) || (c == 0xc2 && next < 0xa0))
      return false;
    i += more + 1;
  }
  return true;
}

/// A string of YAML; what is no text becomes question marks.
std::string quoted(const std::string& name) {
  const bool text = is_text(name);
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') out += '\\';
    out += !text && (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) ? '?' : c;
  }
  return out + "\"";
}

Result<Table> read_table(const std::filesystem::path& file) {
  auto bytes = files::read_file(file, LoadOptions{}.max_bytes);
  if (bytes && bytes->compare(0, 2, "\x1f\x8b") == 0)
    bytes = files::gunzip(*bytes, LoadOptions{}.max_bytes, file.string());
  if (!bytes) return Failure(bytes.error());
  std::string_view text = *bytes;
  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
  if (!csv_format().sniff(text.substr(0, 1 << 16)))
    return bad_input("is no CSV with a header", file.string(),
                     "Topics of other logs take a topic map; omniflight info FILE lists them");
  std::string_view line = text.substr(0, text.find('\n'));
  if (line.substr(0, 1) == "#") line.remove_prefix(1);
  const char separator = separator_of(line);
  std::vector<std::string_view> cells;
  split_row(line, separator, cells);
  if (cells.size() > kMaxColumns)
    return bad_input("has more than 2000 columns", file.string(), "Export fewer");
  Table table{{cells.begin(), cells.end()}, std::vector<Range>(cells.size())};
  std::size_t rows = 0;
  for (auto at = text.find('\n'); at < text.size() && rows < kRows; ++rows) {
    const auto end = std::min(text.find('\n', at + 1), text.size());
    split_row(text.substr(at + 1, end - at - 1), separator, cells);
    at = end;
    for (std::size_t i = 0; i < std::min(cells.size(), table.ranges.size()); ++i) {
      double value = 0;
      const Cell kind = parse_cell(cells[i], separator != ',', value);
      if (kind != Cell::number && kind != Cell::comma) continue;
      Range& r = table.ranges[i];
      r.low = std::min(r.low, value);
      r.high = std::max(r.high, value);
      if (r.numbers++ == 0) r.first = value;
      r.last = value;
    }
  }
  return table;
}

/// The column of the time, and what makes seconds of it; -1: none.
std::pair<int, Scale> find_time(const Table& table) {
  for (int column = 0; column < static_cast<int>(table.header.size()); ++column) {
    const ColumnName name = parse_column_name(table.header[static_cast<std::size_t>(column)]);
    const bool unit_only =
        name.words.size() == 1 && (name.words[0] == "ms" || name.words[0] == "us" || name.words[0] == "ns");
    static const std::set<std::string> times{"t",     "ts", "time", "timestamp", "stamp",
                                             "clock", "ms", "us",   "ns"};
    if (name.component != 0 || name.words.empty() || times.count(name.words.back()) == 0 ||
        !is_text(table.header[static_cast<std::size_t>(column)]))
      continue;
    const std::string unit = unit_only ? name.words[0] : name.unit;
    if (unit == "s") return {column, {1, 0, "seconds by its name"}};
    if (unit == "ms") return {column, {1e-3, 0, "ms by its name"}};
    if (unit == "us") return {column, {1e-6, 0, "us by its name"}};
    if (unit == "ns") return {column, {1e-9, 0, "ns by its name"}};
    const double step =
        table.ranges[static_cast<std::size_t>(column)].mean_step();  // rows come at 1 Hz to 10 kHz
    if (step > 1e5) return {column, {1e-9, 0, "ns by its steps"}};
    if (step > 100) return {column, {1e-6, 0, "us by its steps"}};
    if (step >= 1) return {column, {1e-3, 0, "ms by its steps"}};
    return {column, {1, 0, "seconds by its steps"}};
  }
  return {-1, {}};
}

void write_signal(MapDraft& draft, const Table& table, const ColumnGroup& group, const std::string& signal) {
  double size = 0;
  std::string columns, shown;
  for (const int column : group.columns) {
    const auto at = static_cast<std::size_t>(column);
    size = std::max(size, table.ranges[at].size());
    columns += (columns.empty() ? "" : ", ") + quoted(table.header[at]);
    shown += (shown.empty() ? "" : " ") + files::shown(table.header[at]);
  }
  const Scale scale = scale_of(signal, group, size);
  draft.yaml += "  - {signal: " + signal + ", columns: [" + columns + "]";
  if (scale.factor != 1.0) draft.yaml += ", scale: " + text_of(scale.factor);
  if (scale.offset != 0.0) draft.yaml += ", offset: " + text_of(scale.offset);
  const std::string unit = scale.why.empty() ? "taken as " + std::string(find_spec(signal)->unit) : scale.why;
  draft.yaml += "}   # " + unit + "\n";
  draft.guessed.push_back(signal + " [" + find_spec(signal)->unit + "] from " + shown + ", " + unit);
}

}  // namespace

Result<MapDraft> draft_csv_map(const std::filesystem::path& file) {
  const auto table = read_table(file);
  if (!table) return Failure(table.error());
  const auto [time, scale] = find_time(*table);
  if (time < 0)
    return bad_input("has no column that looks like a time", file.string() + ":1",
                     "Name one t_s, or write the map by hand: docs/how_to/logs.md");
  const auto name_of = [&](int column) { return table->header[static_cast<std::size_t>(column)]; };
  MapDraft draft;
  draft.yaml =
      "schema: omniflight.csv_map/1\ndescription: started from the names and sizes of columns; check every "
      "line\n"
      "time: {column: " +
      quoted(name_of(time)) + ", scale: " + text_of(scale.factor) + "}   # " + scale.why + "\nsignals:\n";
  draft.guessed.push_back("time [s] from " + files::shown(name_of(time)) + ", " + scale.why);
  std::set<std::string> seen;
  std::set<int> used{time};
  for (const ColumnGroup& group : group_columns(table->header)) {
    const char* signal = meaning_of(group);
    const auto usable = [&](int column) {
      return table->ranges[static_cast<std::size_t>(column)].numbers > 0 && is_text(name_of(column));
    };
    if (!signal || !std::all_of(group.columns.begin(), group.columns.end(), usable) ||
        std::count(group.columns.begin(), group.columns.end(), time) > 0 || !seen.insert(signal).second)
      continue;
    write_signal(draft, *table, group, signal);
    used.insert(group.columns.begin(), group.columns.end());
  }
  if (seen.empty())
    return bad_input("has no columns whose names are known", file.string() + ":1",
                     "Write the map by hand: docs/how_to/logs.md");
  for (int column = 0; column < static_cast<int>(table->header.size()); ++column) {
    if (used.count(column)) continue;
    const Range& r = table->ranges[static_cast<std::size_t>(column)];
    const std::string range = r.numbers > 0 ? text_of(r.low) + " to " + text_of(r.high) : "no number";
    draft.yaml += "# not used: " + quoted(name_of(column)) + ", " + range + "\n";
    draft.unused.push_back(files::shown(name_of(column)) + ", " + range);
  }
  return draft;
}

}  // namespace omniflight::recording
