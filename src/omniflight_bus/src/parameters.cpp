#include "omniflight_bus/parameters.hpp"

#include <cmath>
#include <filesystem>

namespace omniflight::bus {
namespace {

constexpr std::uintmax_t max_file_bytes = 1 << 20;

std::string place(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : file + ":" + std::to_string(mark.line + 1);
}

/// Shares the leaves, which keep their line numbers, and builds maps anew, so that an override of one alias
/// leaves the others alone. Aliases can make a small file endless: depth and number of entries are bounded.
class Merge {
 public:
  void operator()(YAML::Node into, const YAML::Node& from, int depth = 0) {
    for (const auto& item : from) {
      if (depth > 32 || ++entries_ > 10000) {
        throw YAML::RepresentationException(item.first.Mark(), "more than 32 levels or 10000 parameters");
      }
      const auto key = item.first.as<std::string>();
      if (!item.second.IsMap()) {
        into.remove(key);
        into[item.first] = item.second;
        continue;
      }
      if (!into[key] || !into[key].IsMap()) {
        into.remove(key);
        into[item.first] = YAML::Node(YAML::NodeType::Map);
      }
      (*this)(into[key], item.second, depth + 1);
    }
  }

 private:
  int entries_ = 0;
};

void merge(const YAML::Node& into, const YAML::Node& from) { Merge()(into, from); }

Status merge_file(YAML::Node into, const std::string& file, const std::string& component) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(file, error);
  if (error) return bad_input("cannot be read: " + error.message(), file, "Name a parameter file");
  if (bytes > max_file_bytes) return bad_input("is larger than 1 MiB", file, "Name a parameter file");
  const YAML::Node root = YAML::LoadFile(file);
  if (root.IsNull()) return {};
  if (!root.IsMap())
    return bad_input("is not a map of component names", file, "Write 'NAME: {ros__parameters: {...}}'");
  for (const std::string& wanted : {std::string("/**"), component, "/" + component}) {
    const YAML::Node entry = root[wanted];
    if (!entry) continue;
    if (!entry.IsMap() || entry.size() != 1 || !entry["ros__parameters"] ||
        !(entry["ros__parameters"].IsMap() || entry["ros__parameters"].IsNull())) {
      return bad_input("'" + wanted + "' must hold one map named ros__parameters", place(file, entry.Mark()),
                       "Write '" + wanted + ": {ros__parameters: {...}}'");
    }
    if (entry["ros__parameters"].IsMap()) merge(into, entry["ros__parameters"]);
  }
  return {};
}

Status apply_override(YAML::Node into, const std::string& text, const std::string& component) {
  const auto assign = text.find(":=");
  std::string key = text.substr(0, assign);
  if (const auto colon = key.find(':'); assign != std::string::npos && colon != std::string::npos) {
    std::string target = key.substr(0, colon);
    if (target.starts_with('/')) target.erase(0, 1);
    key.erase(0, colon + 1);
    if (target != component) return {};
  }
  if (assign == std::string::npos || key.empty()) {
    return bad_input("'" + text + "' is no parameter", "--param", "Write key:=value or component:key:=value");
  }
  YAML::Node map;
  map[key.substr(key.rfind('.') == std::string::npos ? 0 : key.rfind('.') + 1)] =
      YAML::Load(text.substr(assign + 2));
  for (auto end = key.rfind('.'); end != std::string::npos && end > 0; end = key.rfind('.', end - 1)) {
    const auto begin = key.rfind('.', end - 1);
    const auto from = begin == std::string::npos ? 0 : begin + 1;
    YAML::Node outer;
    outer[key.substr(from, end - from)] = map;
    map = outer;
  }
  merge(into, map);
  return {};
}

}  // namespace

Result<YAML::Node> load_parameters(const std::vector<std::string>& files,
                                   const std::vector<std::string>& overrides, const std::string& component) {
  YAML::Node out(YAML::NodeType::Map);
  std::string where;
  try {
    for (const std::string& file : files) {
      where = file;
      if (const Status merged = merge_file(out, file, component); !merged) return Failure(merged.error());
    }
    for (const std::string& text : overrides) {
      where = "--param " + text;
      if (const Status applied = apply_override(out, text, component); !applied)
        return Failure(applied.error());
    }
  } catch (const YAML::Exception& error) {
    return bad_input(error.msg, place(where, error.mark), "Correct the YAML");
  }
  return out;
}

Parameters::Parameters(YAML::Node map, std::string where) : map_(std::move(map)), where_(std::move(where)) {
  if (map_.IsDefined() && !map_.IsMap() && !map_.IsNull())
    reject("", map_, "is not a map", "Write key: value");
}

bool Parameters::has(const std::string& key) const {
  const YAML::Node& map = map_;
  return map.IsMap() && map[key].IsDefined();
}

std::optional<YAML::Node> Parameters::find(const std::string& key, bool required) {
  asked_.insert(key);
  if (has(key)) return map_[key];
  if (required && !error_)
    error_ = Error{ErrorCode::bad_input, "'" + key + "' is missing", where_, "Set " + key};
  return std::nullopt;
}

void Parameters::reject(const std::string& key, const YAML::Node& value, const std::string& what,
                        const std::string& next) {
  if (error_) return;
  const std::string shown = value.IsScalar() ? " = '" + value.Scalar().substr(0, 60) + "'" : std::string();
  error_ =
      Error{ErrorCode::bad_input, "'" + key + "'" + shown + " " + what, place(where_, value.Mark()), next};
}

double Parameters::number(const std::string& key, std::optional<double> fallback, double min, double max) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or(0.0);
  double value = 0.0;
  if (!node->IsScalar() || !YAML::convert<double>::decode(*node, value) || !std::isfinite(value) ||
      value < min || value > max) {
    char range[80];
    std::snprintf(range, sizeof(range), "Give a finite number from %g to %g", min, max);
    reject(key, *node, "is not usable", range);
    return 0.0;
  }
  return value;
}

std::int64_t Parameters::integer(const std::string& key, std::optional<std::int64_t> fallback,
                                 std::int64_t min, std::int64_t max) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or(0);
  std::int64_t value = 0;
  if (!node->IsScalar() || !YAML::convert<std::int64_t>::decode(*node, value) || value < min || value > max) {
    reject(key, *node, "is not usable",
           "Give a whole number from " + std::to_string(min) + " to " + std::to_string(max));
    return 0;
  }
  return value;
}

bool Parameters::flag(const std::string& key, std::optional<bool> fallback) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or(false);
  bool value = false;
  if (!node->IsScalar() || !YAML::convert<bool>::decode(*node, value)) {
    reject(key, *node, "is neither true nor false", "Write true or false");
  }
  return value;
}

std::string Parameters::text(const std::string& key, std::optional<std::string> fallback) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or("");
  if (!node->IsScalar()) {
    reject(key, *node, "is not a text", "Write one value");
    return {};
  }
  return node->Scalar();
}

std::vector<double> Parameters::numbers(const std::string& key, std::optional<std::vector<double>> fallback,
                                        std::size_t size) {
  const auto node = find(key, !fallback);
  if (!node) return fallback.value_or(std::vector<double>(size, 0.0));
  std::vector<double> values;
  bool valid = node->IsSequence() && (size == 0 || node->size() == size) && node->size() <= 100000;
  for (std::size_t i = 0; valid && i < node->size(); ++i) {
    double value = 0.0;
    const YAML::Node element = (*node)[i];
    valid = element.IsScalar() && YAML::convert<double>::decode(element, value) && std::isfinite(value);
    values.push_back(value);
  }
  if (valid) return values;
  reject(key, *node, "is not a list of finite numbers",
         size > 0 ? "Give " + std::to_string(size) + " numbers" : std::string("Write [a, b, ...]"));
  return std::vector<double>(size, 0.0);
}

Status Parameters::finish() const {
  if (error_) return Failure(*error_);
  const YAML::Node& map = map_;
  for (const auto& item : map.IsMap() ? map : YAML::Node(YAML::NodeType::Map)) {
    const std::string key = item.first.IsScalar() ? item.first.Scalar() : "?";
    if (asked_.contains(key)) continue;
    std::string known;
    for (const std::string& name : asked_) known += (known.empty() ? "" : ", ") + name;
    return bad_input("unknown parameter '" + key + "'", place(where_, item.first.Mark()),
                     "Known are " + known);
  }
  return {};
}

}  // namespace omniflight::bus
