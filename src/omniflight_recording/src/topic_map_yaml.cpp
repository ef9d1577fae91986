// Topic maps in YAML.
#include <algorithm>
#include <map>

#include "omniflight_files/files.hpp"
#include "omniflight_files/yaml.hpp"
#include "omniflight_recording/recording.hpp"
#include "topic_map.hpp"

namespace omniflight::recording {
namespace {

using files::YamlReader;

/// Units that logs have, and what makes them SI.
struct Unit {
  const char* name;
  const char* si;
  double scale;
  double offset = 0;
};
const std::vector<Unit>& units() {
  static const std::vector<Unit> table{{"cm", "m", 1e-2},
                                       {"mm", "m", 1e-3},
                                       {"cm/s", "m/s", 1e-2},
                                       {"g", "m/s2", kGravity},
                                       {"deg", "rad", kPi / 180},
                                       {"deg/s", "rad/s", kPi / 180},
                                       {"rev/min", "rad/s", kPi / 30},
                                       {"mV", "V", 1e-3},
                                       {"mA", "A", 1e-3},
                                       {"percent", "1", 1e-2},
                                       {"pwm_us", "1", 1e-3, -1.0}};  // 1000 to 2000 us are 0 to 1
  return table;
}

void read_unit(YamlReader& item, const SignalSpec& spec, TopicSignal& out) {
  const std::string unit = item.string("unit", spec.unit);
  if (unit == spec.unit) return;
  std::string known = spec.unit;
  for (const Unit& u : units()) {
    if (std::string_view(u.si) != spec.unit) continue;
    if (unit == u.name) {
      out.scale = u.scale;
      out.offset = u.offset;
      return;
    }
    known += std::string(", ") + u.name;
  }
  item.error_at("unit", files::shown(unit) + " is no unit of " + spec.name, "Known: " + known);
}

Axes read_axes(YamlReader& item, Geometry geometry, bool turned) {
  const std::string frame = item.string("frame", "");
  if (frame.empty()) return Axes::as_they_are;
  struct Choice {
    const char* name;
    Geometry of;
    Axes axes;
  };
  static const Choice choices[] = {
      {"enu", Geometry::world_vector, Axes::as_they_are}, {"ned", Geometry::world_vector, Axes::ned},
      {"flu", Geometry::body_vector, Axes::as_they_are},  {"frd", Geometry::body_vector, Axes::frd},
      {"enu_flu", Geometry::attitude, Axes::as_they_are}, {"ned_frd", Geometry::attitude, Axes::ned_frd}};
  const Geometry wanted = turned ? Geometry::body_vector : geometry;
  std::string known;
  for (const Choice& c : choices) {
    if (c.of != wanted) continue;
    if (frame == c.name) return c.axes;
    known += (known.empty() ? "" : " or ") + std::string(c.name);
  }
  item.error_at("frame", files::shown(frame) + " is no frame of this signal",
                known.empty() ? "Leave it out" : "Use " + known);
  return Axes::as_they_are;
}

std::vector<FieldCondition> read_conditions(YamlReader& item) {
  std::vector<FieldCondition> out;
  for (auto& condition : item.children("where", 0, 10)) {
    FieldCondition c;
    c.field = condition.string("field");
    c.equals = condition.has("equals");
    c.value = condition.number(c.equals ? "equals" : "differs", files::any_number());
    out.push_back(std::move(c));
  }
  return out;
}

TopicSignal read_signal(YamlReader& item) {
  TopicSignal out;
  out.signal = item.string("signal");
  const SignalSpec* spec = find_spec(out.signal);
  if (!spec) {
    std::vector<std::string> names;
    for (const auto& s : canonical_signals()) names.emplace_back(s.name);
    const std::string near = files::nearest_word(out.signal, names);
    item.error_at("signal", files::shown(out.signal) + " is no canonical signal",
                  near.empty() ? "See the list in the README" : "Did you mean " + files::shown(near) + "?");
    return out;
  }
  const Geometry geometry = geometry_of(out.signal);
  out.fields = item.strings("fields");
  if (out.fields.empty() || out.fields.size() > 32 ||
      (spec->width > 0 && out.fields.size() > 1 && static_cast<int>(out.fields.size()) != spec->width))
    item.error_at("fields", out.signal + " has " + std::to_string(spec->width) + " components",
                  "Name one field for each, or one array");
  out.turned_by = item.strings("turned_by", false);
  if (!out.turned_by.empty() && (geometry != Geometry::world_vector || out.turned_by.size() > 4 ||
                                 (out.turned_by.size() != 1 && out.turned_by.size() != 4)))
    item.error_at("turned_by", "turns a world vector that is logged in body axes",
                  "Name the four fields w, x, y, z of the attitude, or one array");
  out.axes = read_axes(item, geometry, !out.turned_by.empty());
  out.xyzw = item.string("quaternion", "wxyz") == "xyzw";
  if (item.has("quaternion") && (geometry != Geometry::attitude || item.string("quaternion").size() != 4 ||
                                 (!out.xyzw && item.string("quaternion") != "wxyz")))
    item.error_at("quaternion", "is the order of the numbers of an attitude", "Use wxyz or xyzw");
  read_unit(item, *spec, out);
  out.scale *= item.number("scale", files::any_number(), 1.0);
  out.offset += item.number("offset", files::any_number(), 0.0);
  out.count = item.string("count", "");
  out.unused_nan = item.boolean("unused_nan", false);
  if (item.has("range")) {
    const auto range = item.numbers("range", 2, files::any_number());
    if (range.size() == 2) out.least = range[0], out.most = range[1];
  }
  out.where = read_conditions(item);
  return out;
}

TopicEntry read_entry(YamlReader& item, const std::string& map) {
  TopicEntry out;
  out.map = map;
  out.topic = item.string("topic", "");
  out.type = short_type(item.string("type", ""));
  if (out.topic.empty() && out.type.empty())
    item.error("has neither topic nor type", "Say which topic it is about");
  if (auto time = item.optional_child("time")) {
    out.time = time->strings("fields");
    out.time_ns = time->choice<std::int64_t>(
        "unit", {{"ns", 1}, {"us", 1000}, {"ms", 1'000'000}, {"s", 1'000'000'000}});
  }
  for (auto& signal : item.children("signals", 1, 50)) {
    out.signals.push_back(read_signal(signal));
    if (!item.ok()) break;
  }
  return out;
}

}  // namespace

Result<TopicMap> load_topic_map(const std::filesystem::path& file) {
  auto root = YamlReader::load(file);
  if (!root) return Failure(root.error());
  TopicMap out;
  if (const std::string schema = root->string("schema"); schema != "omniflight.topic_map/1")
    root->error_at("schema", files::shown(schema) + " is no map of topics",
                   schema == "omniflight.csv_map/1" ? "This map is for CSV; a log with topics takes "
                                                      "omniflight.topic_map/1"
                                                    : "It must be omniflight.topic_map/1");
  root->string("description", "");
  for (auto& item : root->children("topics", 0, 500)) {
    out.entries.push_back(read_entry(item, file.stem().string()));
    if (!root->ok()) break;
  }
  for (auto& item : root->children("definitions", 0, 100)) {
    const std::string type = short_type(item.string("type"));
    auto types = parse_ros_definition(type, item.string("text"));
    if (!types) {
      item.error_at("text", types.error().message, "Give the text of the .msg file");
      break;
    }
    out.definitions.merge(*types);
  }
  if (auto ok = root->finish(); !ok) return Failure(ok.error());
  return out;
}

}  // namespace omniflight::recording
