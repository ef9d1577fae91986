// Parameter files in the manner of ROS 2, and reading them without letting a wrong key or unit pass.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::bus {

/// Reads files of the form
///   /**: {ros__parameters: {key: value}}          # for every component
///   controller: {ros__parameters: {key: value}}   # for this one
/// then applies overrides "key:=value" (every component) and "controller:key:=value"; a dot in key enters a
/// map. Later ones win. Returns the merged map of one component; ErrorCode::bad_input names file and line.
Result<YAML::Node> load_parameters(const std::vector<std::string>& files,
                                   const std::vector<std::string>& overrides, const std::string& component);

/// Checked access to one map. Read everything, then ask finish(): it returns the first error, or the keys
/// that nobody asked for. A missing fallback makes the key required. After an error the functions return a
/// zero value.
class Parameters {
 public:
  Parameters(YAML::Node map, std::string where);

  double number(const std::string& key, std::optional<double> fallback, double min = -1e300,
                double max = 1e300);
  std::int64_t integer(const std::string& key, std::optional<std::int64_t> fallback,
                       std::int64_t min = INT64_MIN, std::int64_t max = INT64_MAX);
  bool flag(const std::string& key, std::optional<bool> fallback);
  std::string text(const std::string& key, std::optional<std::string> fallback);
  /// size 0: any length.
  std::vector<double> numbers(const std::string& key, std::optional<std::vector<double>> fallback,
                              std::size_t size = 0);
  bool has(const std::string& key) const;

  Status finish() const;

 private:
  std::optional<YAML::Node> find(const std::string& key, bool required);
  void reject(const std::string& key, const YAML::Node& value, const std::string& what,
              const std::string& next);
  YAML::Node map_;
  std::string where_;
  std::set<std::string> asked_;
  std::optional<Error> error_;
};

}  // namespace omniflight::bus
