// A finding to JSON and back. What is read may have been changed by anyone: every type is checked, sizes are
// capped.
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "omniflight_reproduction/finding.hpp"
#include "omniflight_reproduction/printed.hpp"

namespace omniflight::reproduction {
namespace {

using nlohmann::json;

constexpr std::size_t kMostItems = 2000, kMostSamples = 100000;

/// JSON has no NaN: null.
json json_number(double x) { return std::isfinite(x) ? json(x) : json(); }
json numbers(const std::vector<double>& values) {
  json out = json::array();
  for (const double x : values) out.push_back(json_number(x));
  return out;
}

json cell(const report::Cell& c) {
  if (const auto* text = std::get_if<std::string>(&c.value)) return *text;
  return json_number(std::get<double>(c.value));
}

json table_json(const report::Table& t) {
  json columns = json::array(), rows = json::array();
  for (const auto& c : t.columns)
    columns.push_back({{"name", c.name}, {"unit", c.unit}, {"digits", c.significant_digits}});
  for (const auto& row : t.rows) {
    json& out = rows.emplace_back(json::array());
    for (const auto& c : row) out.push_back(cell(c));
  }
  return {{"caption", t.caption}, {"columns", columns}, {"rows", rows}};
}

json outlines_json(const report::Outlines& o) {
  json views = json::array();
  for (const auto& view : o.views) {
    json shapes = json::array();
    for (const auto& shape : view.outlines)
      shapes.push_back({{"name", shape.name}, {"points", shape.points}});
    views.push_back({{"x", view.x_label}, {"y", view.y_label}, {"shapes", shapes}});
  }
  return {{"title", o.title}, {"views", views}, {"circle", o.circle}, {"circle_label", o.circle_label}};
}

json plot_json(const report::TimePlot& p) {
  json series = json::array();
  for (const auto& s : p.series)
    series.push_back({{"name", s.name}, {"x", numbers(s.x)}, {"y", numbers(s.y)}, {"dashed", s.dashed}});
  return {{"title", p.title}, {"x", p.x_label}, {"y", p.y_label}, {"series", series}, {"group", p.group}};
}

/// Thrown and caught within this file only.
struct Unreadable {
  const char* what;
};

const json& at(const json& j, const char* key) {
  if (!j.is_object() || !j.contains(key)) throw Unreadable{key};
  return j[key];
}
std::string text(const json& j, const char* key) {
  const json& v = at(j, key);
  if (!v.is_string()) throw Unreadable{key};
  return v.get<std::string>();
}
double value(const json& v, const char* key) {
  if (v.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!v.is_number()) throw Unreadable{key};
  return v.get<double>();
}
const json& list(const json& j, const char* key, std::size_t most = kMostItems) {
  const json& v = at(j, key);
  if (!v.is_array() || v.size() > most) throw Unreadable{key};
  return v;
}
std::vector<double> values(const json& j, const char* key) {
  std::vector<double> out;
  for (const json& v : list(j, key, kMostSamples)) out.push_back(value(v, key));
  return out;
}

report::Table table_of(const json& j) {
  report::Table t;
  t.caption = text(j, "caption");
  for (const json& c : list(j, "columns"))
    t.columns.push_back({.name = text(c, "name"),
                         .unit = text(c, "unit"),
                         .significant_digits = static_cast<int>(value(at(c, "digits"), "digits"))});
  for (const json& row : list(j, "rows")) {
    if (!row.is_array() || row.size() != t.columns.size()) throw Unreadable{"rows"};
    auto& out = t.rows.emplace_back();
    for (const json& c : row)
      out.push_back(c.is_string() ? report::Cell(c.get<std::string>()) : report::Cell(value(c, "rows")));
  }
  return t;
}

report::Outlines outlines_of(const json& j) {
  report::Outlines o;
  o.title = text(j, "title");
  o.circle = value(at(j, "circle"), "circle");
  o.circle_label = text(j, "circle_label");
  for (const json& v : list(j, "views")) {
    auto& view = o.views.emplace_back();
    view.x_label = text(v, "x");
    view.y_label = text(v, "y");
    for (const json& s : list(v, "shapes")) {
      auto& shape = view.outlines.emplace_back();
      shape.name = text(s, "name");
      for (const json& p : list(s, "points", kMostSamples)) {
        if (!p.is_array() || p.size() != 2) throw Unreadable{"points"};
        shape.points.emplace_back(value(p[0], "points"), value(p[1], "points"));
      }
    }
  }
  return o;
}

report::TimePlot plot_of(const json& j) {
  report::TimePlot p;
  p.title = text(j, "title");
  p.x_label = text(j, "x");
  p.y_label = text(j, "y");
  p.group = text(j, "group");
  for (const json& s : list(j, "series")) {
    auto& series = p.series.emplace_back();
    series.name = text(s, "name");
    series.x = values(s, "x");
    series.y = values(s, "y");
    if (!at(s, "dashed").is_boolean()) throw Unreadable{"dashed"};
    series.dashed = s["dashed"].get<bool>();
  }
  return p;
}

json row_json(const Row& row) {
  json readings = json::array();
  for (const Reading& r : row.readings)
    readings.push_back({{"assumption", r.assumption}, {"value", json_number(r.value)}});
  json out{{"key", row.key},
           {"what", row.what},
           {"unit", row.unit},
           {"readings", readings},
           {"chosen", row.chosen ? json(*row.chosen) : json()},
           {"verdict", word(row.verdict())}};
  if (const Printed* p = find_printed(row.key))
    out["printed"] = {{"value", p->value},
                      {"tolerance", p->tolerance},
                      {"tolerance_is_factor", p->factor},
                      {"because", p->because},
                      {"source", p->source}};
  return out;
}

Row row_of(const json& j) {
  Row row{.key = text(j, "key"), .what = text(j, "what"), .unit = text(j, "unit"), .readings = {}};
  if (!row.key.empty() && !find_printed(row.key)) throw Unreadable{"key"};
  for (const json& r : list(j, "readings"))
    row.readings.push_back({text(r, "assumption"), value(at(r, "value"), "value")});
  if (const json& chosen = at(j, "chosen"); !chosen.is_null()) {
    if (!chosen.is_number_unsigned() || chosen.get<std::size_t>() >= row.readings.size())
      throw Unreadable{"chosen"};
    row.chosen = chosen.get<std::size_t>();
  }
  return row;
}

}  // namespace

json to_json(const Finding& f) {
  json j{{"verdict", word(f.verdict())}, {"reasons", f.reasons()},
         {"rows", json::array()},        {"notes", f.notes},
         {"tables", json::array()},      {"outlines", json::array()},
         {"plots", json::array()}};
  for (const auto& row : f.rows) j["rows"].push_back(row_json(row));
  for (const auto& t : f.tables) j["tables"].push_back(table_json(t));
  for (const auto& o : f.outlines) j["outlines"].push_back(outlines_json(o));
  for (const auto& p : f.plots) j["plots"].push_back(plot_json(p));
  return j;
}

Result<Finding> finding_from_json(const json& j) {
  Finding f;
  try {
    for (const json& row : list(j, "rows")) f.rows.push_back(row_of(row));
    for (const json& note : list(j, "notes")) {
      if (!note.is_string()) throw Unreadable{"notes"};
      f.notes.push_back(note.get<std::string>());
    }
    for (const json& t : list(j, "tables")) f.tables.push_back(table_of(t));
    for (const json& o : list(j, "outlines")) f.outlines.push_back(outlines_of(o));
    for (const json& p : list(j, "plots")) f.plots.push_back(plot_of(p));
  } catch (const Unreadable& e) {
    return bad_input("is missing, too long or of another kind than a finding has", e.what,
                     "Delete the file; the figure is computed again");
  }
  return f;
}

}  // namespace omniflight::reproduction
