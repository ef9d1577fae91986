// Canonical CSV column names, both ways: column <-> (signal, component).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace omniflight::recording {

struct ColumnPlace {
  std::string signal;
  int component;  // from 0
};

/// "px_m" -> {position, 0}; "rotor2_cmd_radps" -> {rotor_command, 1}; "truth_position_3" -> {truth_position,
/// 2}.
std::optional<ColumnPlace> place_of_column(std::string_view column);

/// The reverse: "position", 0 -> "px_m".
std::string column_of(const std::string& signal, int component, int width);

}  // namespace omniflight::recording
