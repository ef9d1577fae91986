#include "csv_map.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "csv_columns.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {
namespace {

int index_of(const std::vector<std::string>& header, const std::string& column) {
  const auto found = std::find(header.begin(), header.end(), column);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

/// The column's index, or an error that names the nearest column.
int column_at(const std::vector<std::string>& header, const std::string& column, files::YamlReader& where) {
  const int index = index_of(header, column);
  if (index < 0) {
    const std::string near = files::nearest_word(column, header);
    where.error("the file has no column " + files::shown(column),
                near.empty() ? "Name one of its columns" : "Did you mean " + files::shown(near) + "?");
  }
  return index;
}

/// A signal all of whose components stand in one cell.
CsvSignal list_signal(const SignalSpec& spec, int column) {
  CsvSignal signal;
  signal.signal = spec.name;
  signal.unit = spec.unit;
  signal.columns = {column};
  signal.list = true;
  signal.width = static_cast<std::size_t>(spec.width);
  return signal;
}

Result<CsvLayout> canonical_layout(const std::vector<std::string>& header, const std::string& file) {
  CsvLayout layout;
  std::map<std::string, std::map<int, int>> found;  // signal -> component -> column
  std::map<std::string, int> lists;                 // signal -> column whose cells hold all components
  for (int column = 0; column < static_cast<int>(header.size()); ++column) {
    const std::string& name = header[static_cast<std::size_t>(column)];
    if (std::count(header.begin(), header.end(), name) > 1)
      return bad_input("column " + files::shown(name) + " appears twice", file + ":1", "Rename one of them");
    if (name == "t_s") {
      layout.time_column = column;
    } else if (const auto place = place_of_column(name)) {
      found[place->signal][place->component] = column;
    } else if (find_spec(name)) {
      lists[name] = column;
    } else {
      layout.ignored.push_back(name);
    }
  }
  if (layout.time_column < 0)
    return bad_input("there is no column t_s (time in seconds), and no map under configs/csv_maps fits",
                     file + ":1",
                     "Rename the time column, or describe the columns with --map FILE (omniflight new map "
                     "NAME --from FILE starts one)");
  for (const auto& [name, column] : lists) {
    if (found.count(name))
      return bad_input("column " + files::shown(name) + " is a list of what other columns have, too",
                       file + ":1", "Remove it, or the others");
    layout.signals.push_back(list_signal(*find_spec(name), column));
  }
  for (const auto& [name, components] : found) {
    const SignalSpec* spec = find_spec(name);
    const int width = spec->width > 0 ? spec->width : components.rbegin()->first + 1;
    CsvSignal signal;
    signal.signal = name;
    signal.unit = spec->unit;
    for (int c = 0; c < width; ++c) {
      if (!components.count(c))
        return bad_input("column " + column_of(name, c, width) + " is missing beside the others of " + name,
                         file + ":1", "Add it, or remove the others");
      signal.columns.push_back(components.at(c));
    }
    layout.signals.push_back(std::move(signal));
  }
  return layout;
}

/// The columns of one signal of a map; without a name where the map is wrong about it.
CsvSignal mapped_signal(files::YamlReader& item, const std::vector<std::string>& header) {
  const std::string name = item.string("signal");
  const SignalSpec* spec = find_spec(name);
  if (!spec) {
    std::vector<std::string> names;
    for (const auto& s : canonical_signals()) names.emplace_back(s.name);
    const std::string near = files::nearest_word(name, names);
    item.error_at("signal", files::shown(name) + " is no canonical signal",
                  near.empty() ? "See the list in the README" : "Did you mean " + files::shown(near) + "?");
    return {};
  }
  CsvSignal signal;
  const std::string list = item.string("list", "");
  if (!list.empty()) {
    signal = list_signal(*spec, column_at(header, list, item));
    if (item.has("columns")) item.error_at("list", "stands beside columns", "Keep one of the two");
    const std::string order = item.string("quaternion", "wxyz");
    if ((order != "wxyz" && order != "xyzw") || (item.has("quaternion") && !is_attitude(name)))
      item.error_at("quaternion", files::shown(order) + " is no order of this signal",
                    is_attitude(name) ? "Use wxyz or xyzw" : "Leave it out");
    signal.xyzw = order == "xyzw";
  } else {
    const auto columns = item.strings("columns");
    if (columns.empty() || (spec->width > 0 && static_cast<int>(columns.size()) != spec->width))
      item.error_at("columns", name + " has " + std::to_string(spec->width) + " components",
                    "Name one column for each, or with list: the one whose cells hold all of them");
    for (const auto& column : columns) signal.columns.push_back(column_at(header, column, item));
    signal.signal = name;
    signal.unit = spec->unit;
  }
  signal.scale = item.number("scale", files::any_number(), 1.0);
  signal.offset = item.number("offset", files::any_number(), 0.0);
  return signal;
}

Result<CsvLayout> mapped_layout(const std::vector<std::string>& header, const std::string& file,
                                const std::filesystem::path& map) {
  auto root = files::YamlReader::load(map);
  if (!root) return Failure(root.error());
  CsvLayout layout;
  if (root->string("schema") != "omniflight.csv_map/1")
    root->error_at("schema", "must be omniflight.csv_map/1", "Correct the schema");
  root->string("description", "");
  auto time = root->child("time");
  layout.time_column = column_at(header, time.string("column"), time);
  layout.time_scale = time.number("scale", files::positive("s"), 1.0);
  std::set<std::string> seen;
  for (auto& item : root->children("signals", 1, 200)) {
    auto signal = mapped_signal(item, header);
    if (signal.signal.empty()) break;  // the error stands in the reader
    if (!seen.insert(signal.signal).second) item.error_at("signal", "appears twice", "Remove one");
    layout.signals.push_back(std::move(signal));
  }
  if (auto ok = root->finish(); !ok) {
    Error error = ok.error();
    error.message += " (reading " + file + ")";
    return Failure(error);
  }
  return layout;
}

/// Maps under configs/csv_maps by name; none without that folder.
std::vector<std::filesystem::path> known_maps() {
  std::vector<std::filesystem::path> out;
  const auto configs = files::config_dir();
  if (!configs) return out;
  std::error_code ec;
  for (const auto& entry : std::filesystem::directory_iterator(*configs / "csv_maps", ec))
    if (entry.path().extension() == ".yaml") out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Result<CsvLayout> layout_of(const std::vector<std::string>& header, const std::string& file,
                            const std::filesystem::path& map) {
  if (!map.empty()) {
    std::error_code ec;
    if (!map.has_parent_path() && !std::filesystem::exists(map, ec))
      for (const auto& known : known_maps())
        if (known.stem() == map) return mapped_layout(header, file, known);
    return mapped_layout(header, file, map);
  }
  if (std::find(header.begin(), header.end(), "t_s") == header.end())
    for (const auto& known : known_maps())
      if (auto layout = mapped_layout(header, file, known)) {
        layout->found_map = known;
        return layout;
      }
  return canonical_layout(header, file);
}

}  // namespace omniflight::recording
