#include "message_definition.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

namespace omniflight::recording {
namespace {

constexpr std::size_t kMaxText = 1u << 20, kMaxFields = 1000, kMaxTypes = 4096;

std::string_view next_word(std::string_view& line) {
  const auto begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return line = {};
  const auto end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const auto word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// "float64[6]", "string<=10[<=3]", "geometry_msgs/Point[]".
std::optional<FieldDefinition> parse_type(std::string_view text) {
  FieldDefinition f;
  if (const auto bracket = text.find('['); bracket != std::string_view::npos) {
    if (text.back() != ']') return std::nullopt;
    f.array = true;
    const auto inside = text.substr(bracket + 1, text.size() - bracket - 2);
    if (!inside.empty() && inside[0] != '<') {
      const auto r = std::from_chars(inside.data(), inside.data() + inside.size(), f.fixed);
      if (r.ec != std::errc() || r.ptr != inside.data() + inside.size() || f.fixed == 0) return std::nullopt;
    }
    text = text.substr(0, bracket);
  }
  f.type = std::string(text.substr(0, text.find("<=")));
  if (f.type.empty()) return std::nullopt;
  return f;
}

bool parse_ros(const std::string& root, std::string_view text, MessageTypes& types) {
  std::string current = root;
  types[current];
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find('#'));
    if (line.substr(0, 3) == "===") continue;
    const auto type = next_word(line);
    if (type.empty()) continue;
    if (type == "MSG:") {
      current = short_type(std::string(next_word(line)));
      types[current].clear();
      continue;
    }
    const auto name = next_word(line);
    if (name.empty()) return false;
    if (name.find('=') != std::string_view::npos || next_word(line).substr(0, 1) == "=")
      continue;  // constant
    auto field = parse_type(type);
    if (!field || types[current].size() > kMaxFields || types.size() > kMaxTypes) return false;
    field->name = std::string(name);
    types[current].push_back(std::move(*field));
  }
  return true;
}

/// The name that ROS has for a primitive of ULog; other names are left as they are.
std::string ros_name(std::string_view ulog) {
  if (ulog == "float") return "float32";
  if (ulog == "double") return "float64";
  if (ulog.size() > 2 && ulog.substr(ulog.size() - 2) == "_t")
    for (const char* known : {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"})
      if (ulog.substr(0, ulog.size() - 2) == known) return known;
  return std::string(ulog);
}

}  // namespace

std::string short_type(std::string name) {
  if (const auto at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

Result<MessageTypes> parse_ros_definition(const std::string& type, std::string_view text) {
  if (text.size() > kMaxText) return bad_input("the message definition is larger than 1 MB", type);
  MessageTypes types;
  if (!parse_ros(short_type(type), text, types))
    return bad_input("the message definition cannot be parsed", type);
  return types;
}

bool add_ulog_format(std::string_view text, MessageTypes& types) {
  const auto colon = text.find(':');
  if (colon == 0 || colon == std::string_view::npos || types.size() >= kMaxTypes) return false;
  std::vector<FieldDefinition> fields;
  const std::string name(text.substr(0, colon));
  text.remove_prefix(colon + 1);
  while (!text.empty()) {
    const auto end = std::min(text.find(';'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    const auto type = next_word(line), field_name = next_word(line);
    auto field = parse_type(type);
    if (field_name.empty() || !field || (field->array && field->fixed == 0) || fields.size() > kMaxFields)
      return false;
    field->type = ros_name(field->type);
    field->name = std::string(field_name);
    fields.push_back(std::move(*field));
  }
  if (fields.empty()) return false;
  types[name] = std::move(fields);
  return true;
}

}  // namespace omniflight::recording
