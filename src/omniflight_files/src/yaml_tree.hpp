// The checked document as our own tree, so that yaml-cpp's lazily shared nodes never reach a caller.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::files {

struct YamlNode {
  enum class Kind { null, scalar, sequence, map };
  Kind kind = Kind::null;
  bool quoted = false;            // a scalar in quotes is text, never a number
  int line = 0;                   // 1-based
  std::string text;               // scalar
  std::vector<std::string> keys;  // map
  std::vector<int> children;      // map values or sequence items
  std::set<std::string> asked;    // keys some getter asked for
  bool opaque = false;            // accepted with whatever it holds
  std::string path;               // set when visited
};

struct YamlState {
  std::string file;
  std::vector<YamlNode> nodes;  // nodes[0] is the root
  std::optional<Error> error;
};

/// Parses and checks; the new nodes are appended to state.nodes. Returns the index of the root.
Result<int> parse_yaml(std::string_view text, YamlState& state);

}  // namespace omniflight::files
