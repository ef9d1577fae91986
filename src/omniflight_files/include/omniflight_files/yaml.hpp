// Guarded YAML: a document is checked while it is parsed, and read through a reader that knows file, line and
// field of everything, checks units, ranges and finiteness, and refuses keys nobody asked for.
//
//   auto root = YamlReader::load("vehicle.yaml");
//   if (!root) return Failure(root.error());
//   Vehicle v;
//   v.mass = root->number("mass", positive("kg"));
//   for (YamlReader rotor : root->children("rotors", 1, 16)) v.add(rotor.vec3("position", any_number("m")));
//   if (auto ok = root->finish(); !ok) return Failure(ok.error());   // first error, or an unknown key
//
// After the first error all getters return harmless values; so check once, at the end.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::files {

/// Allowed values of a number; the unit appears in every error about it.
struct Bounds {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  const char* unit = "";
  bool open_min = false;  ///< min itself is not allowed
};
inline Bounds any_number(const char* unit = "") { return {.unit = unit}; }
inline Bounds positive(const char* unit = "") { return {.min = 0.0, .unit = unit, .open_min = true}; }
inline Bounds non_negative(const char* unit = "") { return {.min = 0.0, .unit = unit}; }
inline Bounds between(double min, double max, const char* unit = "") {
  return {.min = min, .max = max, .unit = unit};
}

struct YamlState;

/// A place in a document. Cheap to copy; copies and children share the document and its first error.
class YamlReader {
 public:
  /// Parses text (`name` appears in errors). Refuses: more than 1 MB, invalid UTF-8, anchors and aliases,
  /// tags, duplicate keys, keys that are not plain text, more than one document, nesting deeper than 64.
  static Result<YamlReader> parse(std::string_view text, const std::string& name);
  static Result<YamlReader> load(const std::filesystem::path& path);

  /// Replaces or adds one value before reading, as in `--set rotors[0].radius=0.1`; value is YAML text.
  Status override_value(const std::string& path, const std::string& value);

  // --- Where we are -------------------------------------------------------------------------------------
  std::string where() const;  ///< "vehicle.yaml:12: rotors[3].position"
  const std::string& file() const;
  int line() const;
  bool is_map() const;
  bool is_sequence() const;
  bool is_scalar() const;
  bool has(const std::string& key) const;  ///< present and not null; counts as asked for
  std::vector<std::string> keys() const;   ///< of a map, in the order of the file

  // --- Fields of a map (the value of `key`) -------------------------------------------------------------
  double number(const std::string& key, Bounds bounds);
  double number(const std::string& key, Bounds bounds, double otherwise);
  std::int64_t integer(const std::string& key, std::int64_t min, std::int64_t max);
  std::int64_t integer(const std::string& key, std::int64_t min, std::int64_t max, std::int64_t otherwise);
  std::string string(const std::string& key);
  std::string string(const std::string& key, const std::string& otherwise);
  bool boolean(const std::string& key);
  bool boolean(const std::string& key, bool otherwise);
  /// Exactly `count` numbers (any count when 0, at most 100000).
  std::vector<double> numbers(const std::string& key, std::size_t count, Bounds bounds);
  Eigen::Vector3d vec3(const std::string& key, Bounds bounds);
  Eigen::Vector3d vec3(const std::string& key, Bounds bounds, const Eigen::Vector3d& otherwise);
  std::vector<std::string> strings(const std::string& key, bool required = true);
  /// One of the named choices.
  template <class Enum>
  Enum choice(const std::string& key, std::initializer_list<std::pair<const char*, Enum>> choices,
              std::optional<Enum> otherwise = std::nullopt) {
    std::vector<std::string> names;
    for (const auto& c : choices) names.emplace_back(c.first);
    const int index = choice_index(key, names, otherwise.has_value());
    if (index < 0) return otherwise ? *otherwise : choices.begin()->second;
    return (choices.begin() + index)->second;
  }
  /// The map or list at `key`; it must exist.
  YamlReader child(const std::string& key);
  /// The map or list at `key`, or nothing when it is absent or null.
  std::optional<YamlReader> optional_child(const std::string& key);
  /// Items of the list at `key`; an absent list is empty when min == 0.
  std::vector<YamlReader> children(const std::string& key, std::size_t min = 0, std::size_t max = 100000);
  /// Accepts `key` with whatever it holds.
  void ignore(const std::string& key);

  // --- This place itself --------------------------------------------------------------------------------
  double as_number(Bounds bounds);
  std::string as_string();
  Eigen::Vector3d as_vec3(Bounds bounds);
  std::vector<double> as_numbers(std::size_t count, Bounds bounds);
  std::vector<YamlReader> items();  ///< of a list

  // --- Verdict ------------------------------------------------------------------------------------------
  /// Records an error about this place (or one of its fields) unless there is one already.
  void error(const std::string& message, const std::string& next_step = {});
  void error_at(const std::string& key, const std::string& message, const std::string& next_step = {});
  /// Refuses keys of this map outside the list, naming the closest known one.
  void refuse_unknown(const std::vector<std::string>& known);
  bool ok() const;
  Status status() const;  ///< the first error
  /// status(), and refuses every key of every visited map that no getter asked for.
  Status finish();

 private:
  YamlReader(std::shared_ptr<YamlState> state, int node, std::string path)
      : state_(std::move(state)), node_(node), path_(std::move(path)) {}
  YamlReader field(const std::string& key) const;  // node_ == -1 - line of the parent when it is missing
  YamlReader required(const std::string& key);
  bool missing() const { return node_ < 0; }
  bool null() const;
  int choice_index(const std::string& key, const std::vector<std::string>& names, bool optional);

  std::shared_ptr<YamlState> state_;
  int node_ = -1;
  std::string path_;
};

}  // namespace omniflight::files
