#include "omniflight_files/yaml.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "omniflight_files/files.hpp"
#include "yaml_tree.hpp"

namespace omniflight::files {
namespace {

std::string show(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

std::string with_unit(const std::string& text, const char* unit) { return *unit ? text + " " + unit : text; }

/// Strict decimal number: no hexadecimal, no leading zero (YAML 1.1 octal), no nan or inf.
std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  if (text.empty() || text[0] == '+') return std::nullopt;
  const std::string_view digits = text[0] == '-' ? text.substr(1) : text;
  if (digits.empty() || !(std::isdigit(static_cast<unsigned char>(digits[0])) || digits[0] == '.'))
    return std::nullopt;
  if (digits.size() > 1 && digits[0] == '0' && std::isdigit(static_cast<unsigned char>(digits[1])))
    return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

Result<YamlReader> YamlReader::parse(std::string_view text, const std::string& name) {
  auto state = std::make_shared<YamlState>();
  state->file = name;
  const auto root = parse_yaml(text, *state);
  if (!root) return Failure(root.error());
  return YamlReader(std::move(state), *root, "");
}

Result<YamlReader> YamlReader::load(const std::filesystem::path& path) {
  const auto text = read_file(path, kMegabyte);
  if (!text) return Failure(text.error());
  return parse(*text, path.string());
}

std::string YamlReader::where() const {
  std::string out = state_->file + ":" + std::to_string(line());
  return path_.empty() ? out : out + ": " + path_;
}
const std::string& YamlReader::file() const { return state_->file; }
int YamlReader::line() const {
  return node_ >= 0 ? state_->nodes[static_cast<std::size_t>(node_)].line : -1 - node_;
}

namespace {
bool kind_is(const YamlState& s, int node, YamlNode::Kind kind) {
  return node >= 0 && s.nodes[static_cast<std::size_t>(node)].kind == kind;
}
}  // namespace

bool YamlReader::is_map() const { return kind_is(*state_, node_, YamlNode::Kind::map); }
bool YamlReader::is_sequence() const { return kind_is(*state_, node_, YamlNode::Kind::sequence); }
bool YamlReader::is_scalar() const { return kind_is(*state_, node_, YamlNode::Kind::scalar); }
bool YamlReader::null() const { return kind_is(*state_, node_, YamlNode::Kind::null); }

bool YamlReader::has(const std::string& key) const {
  const YamlReader f = field(key);
  return !f.missing() && !f.null();
}

std::vector<std::string> YamlReader::keys() const {
  return is_map() ? state_->nodes[static_cast<std::size_t>(node_)].keys : std::vector<std::string>{};
}

YamlReader YamlReader::field(const std::string& key) const {
  const std::string path = path_.empty() ? key : path_ + "." + key;
  if (!is_map()) return YamlReader(state_, -1 - line(), path);
  YamlNode& node = state_->nodes[static_cast<std::size_t>(node_)];
  node.asked.insert(key);
  node.path = path_;
  const auto found = std::find(node.keys.begin(), node.keys.end(), key);
  if (found == node.keys.end()) return YamlReader(state_, -1 - node.line, path);
  return YamlReader(state_, node.children[static_cast<std::size_t>(found - node.keys.begin())], path);
}

YamlReader YamlReader::required(const std::string& key) {
  if (!missing() && !is_map()) error("must be a map of keys and values", "Write key: value lines");
  YamlReader f = field(key);
  if (f.missing() && !missing()) {
    const std::string near = nearest_word(key, keys());
    f.error("is missing",
            near.empty() ? "Add the key " + key : "Add it; did you mean it by " + shown(near) + "?");
  }
  return f;
}

// --- Scalars
// ------------------------------------------------------------------------------------------------

double YamlReader::as_number(Bounds bounds) {
  const double harmless = std::isfinite(bounds.min) && bounds.min >= 0 ? std::max(1.0, bounds.min) : 0.0;
  if (missing()) return harmless;
  const YamlNode& node = state_->nodes[static_cast<std::size_t>(node_)];
  const auto value = is_scalar() && !node.quoted ? parse_number(node.text) : std::nullopt;
  if (!value) {
    error(is_scalar() ? shown(node.text) + " is not a finite decimal number" : "must be a number",
          *bounds.unit ? std::string("Give a number in ") + bounds.unit + " without the unit"
                       : "Give a number");
    return harmless;
  }
  if (*value < bounds.min || *value > bounds.max || (bounds.open_min && *value <= bounds.min)) {
    const std::string low = (bounds.open_min ? "more than " : "at least ") + show(bounds.min);
    const std::string high = "at most " + show(bounds.max);
    const bool has_low = std::isfinite(bounds.min), has_high = std::isfinite(bounds.max);
    error("is " + with_unit(show(*value), bounds.unit) + ", must be " +
              with_unit(has_low && has_high ? low + " and " + high
                        : has_low           ? low
                                            : high,
                        bounds.unit),
          "Correct the value");
    return harmless;
  }
  return *value;
}

std::string YamlReader::as_string() {
  if (missing()) return {};
  if (!is_scalar()) {
    error("must be text", "Give a word or a text in quotes");
    return {};
  }
  return state_->nodes[static_cast<std::size_t>(node_)].text;
}

double YamlReader::number(const std::string& key, Bounds bounds) { return required(key).as_number(bounds); }
double YamlReader::number(const std::string& key, Bounds bounds, double otherwise) {
  return has(key) ? field(key).as_number(bounds) : otherwise;
}

std::int64_t YamlReader::integer(const std::string& key, std::int64_t min, std::int64_t max) {
  YamlReader f = required(key);
  const double value = f.as_number(between(static_cast<double>(min), static_cast<double>(max)));
  if (value != std::floor(value)) f.error("is " + show(value) + ", must be a whole number", "Round it");
  return std::clamp(static_cast<std::int64_t>(value), min, max);
}
std::int64_t YamlReader::integer(const std::string& key, std::int64_t min, std::int64_t max,
                                 std::int64_t otherwise) {
  return has(key) ? integer(key, min, max) : otherwise;
}

std::string YamlReader::string(const std::string& key) { return required(key).as_string(); }
std::string YamlReader::string(const std::string& key, const std::string& otherwise) {
  return has(key) ? field(key).as_string() : otherwise;
}

bool YamlReader::boolean(const std::string& key) {
  YamlReader f = required(key);
  const std::string text = f.as_string();
  if (!f.missing() && text != "true" && text != "false")
    f.error(shown(text) + " is neither true nor false", "Write true or false");
  return text == "true";
}
bool YamlReader::boolean(const std::string& key, bool otherwise) {
  return has(key) ? boolean(key) : otherwise;
}

int YamlReader::choice_index(const std::string& key, const std::vector<std::string>& names, bool optional) {
  if (optional && !has(key)) return -1;
  YamlReader f = required(key);
  const std::string text = f.as_string();
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
  f.error(shown(text) + " is not one of " + list, "Choose one of them");
  return -1;
}

// --- Lists
// --------------------------------------------------------------------------------------------------

std::vector<YamlReader> YamlReader::items() {
  std::vector<YamlReader> out;
  if (missing()) return out;
  if (!is_sequence()) {
    error("must be a list", "Write [a, b, c] or lines that start with '- '");
    return out;
  }
  const auto children = state_->nodes[static_cast<std::size_t>(node_)].children;
  for (std::size_t i = 0; i < children.size(); ++i)
    out.push_back(YamlReader(state_, children[i], path_ + "[" + std::to_string(i) + "]"));
  return out;
}

std::vector<double> YamlReader::as_numbers(std::size_t count, Bounds bounds) {
  std::vector<double> out;
  auto list = items();
  if (ok() && (count > 0 ? list.size() != count : list.size() > 100000))
    error("has " + std::to_string(list.size()) + " numbers, must have " + std::to_string(count),
          "Correct the list");
  for (auto& item : list) out.push_back(item.as_number(bounds));
  if (count > 0) out.resize(count, 0.0);
  return out;
}
std::vector<double> YamlReader::numbers(const std::string& key, std::size_t count, Bounds bounds) {
  return required(key).as_numbers(count, bounds);
}
Eigen::Vector3d YamlReader::as_vec3(Bounds bounds) {
  const auto v = as_numbers(3, bounds);
  return {v[0], v[1], v[2]};
}
Eigen::Vector3d YamlReader::vec3(const std::string& key, Bounds bounds) {
  return required(key).as_vec3(bounds);
}
Eigen::Vector3d YamlReader::vec3(const std::string& key, Bounds bounds, const Eigen::Vector3d& otherwise) {
  return has(key) ? field(key).as_vec3(bounds) : otherwise;
}
std::vector<std::string> YamlReader::strings(const std::string& key, bool required_key) {
  std::vector<std::string> out;
  if (!required_key && !has(key)) return out;
  for (auto& item : required(key).items()) out.push_back(item.as_string());
  return out;
}

// --- Children
// -----------------------------------------------------------------------------------------------

YamlReader YamlReader::child(const std::string& key) {
  YamlReader f = required(key);
  if (!f.missing() && !f.is_map() && !f.is_sequence())
    f.error("must be a map or a list", "Indent its content below it");
  return f;
}
std::optional<YamlReader> YamlReader::optional_child(const std::string& key) {
  if (!has(key)) return std::nullopt;
  return child(key);
}
std::vector<YamlReader> YamlReader::children(const std::string& key, std::size_t min, std::size_t max) {
  if (min == 0 && !has(key)) return {};
  YamlReader f = required(key);
  auto list = f.items();
  if (ok() && (list.size() < min || list.size() > max))
    f.error("has " + std::to_string(list.size()) + " items, must have " + std::to_string(min) + " to " +
                std::to_string(max),
            "Correct the list");
  return list;
}
void YamlReader::ignore(const std::string& key) {
  const YamlReader f = field(key);
  if (!f.missing()) state_->nodes[static_cast<std::size_t>(f.node_)].opaque = true;
}

// --- Verdict
// ------------------------------------------------------------------------------------------------

void YamlReader::error(const std::string& message, const std::string& next_step) {
  if (!state_->error) state_->error = Error{ErrorCode::bad_input, message, where(), next_step};
}
void YamlReader::error_at(const std::string& key, const std::string& message, const std::string& next_step) {
  field(key).error(message, next_step);
}

void YamlReader::refuse_unknown(const std::vector<std::string>& known) {
  for (const auto& key : keys()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string near = nearest_word(key, known);
    std::string list;
    for (const auto& k : known) list += (list.empty() ? "" : ", ") + k;
    field(key).error("is not a known key",
                     near.empty() ? "Known keys: " + list : "Did you mean " + shown(near) + "?");
  }
}

bool YamlReader::ok() const { return !state_->error.has_value(); }
Status YamlReader::status() const {
  if (state_->error) return Failure(*state_->error);
  return {};
}

Status YamlReader::finish() {
  for (std::size_t i = 0; i < state_->nodes.size() && ok(); ++i) {
    const YamlNode& node = state_->nodes[i];
    if (node.asked.empty() || node.opaque) continue;
    const std::vector<std::string> known(node.asked.begin(), node.asked.end());
    YamlReader(state_, static_cast<int>(i), node.path).refuse_unknown(known);
  }
  return status();
}

Status YamlReader::override_value(const std::string& path, const std::string& value) {
  const std::string where = "--set " + shown(path + "=" + value);
  const auto no_place = [&] {
    return bad_input("there is no such field", where, "Name a field such as mass or rotors[0].radius");
  };
  int node = node_, parent = -1;
  std::string last_key;
  for (std::size_t at = 0; at < path.size();) {
    if (node < 0) return no_place();
    parent = node;
    const YamlNode& here = state_->nodes[static_cast<std::size_t>(node)];
    if (path[at] == '[') {
      const std::size_t end = path.find(']', at);
      std::size_t index = 0;
      if (end == std::string::npos || here.kind != YamlNode::Kind::sequence) return no_place();
      const auto parsed = std::from_chars(path.data() + at + 1, path.data() + end, index);
      if (parsed.ec != std::errc() || parsed.ptr != path.data() + end || index >= here.children.size())
        return no_place();
      node = here.children[index];
      last_key.clear();
      at = end + 1;
      if (at < path.size() && path[at] == '.') ++at;
      continue;
    }
    const std::size_t end = std::min(path.find_first_of(".[", at), path.size());
    last_key = path.substr(at, end - at);
    if (here.kind != YamlNode::Kind::map || last_key.empty()) return no_place();
    const auto found = std::find(here.keys.begin(), here.keys.end(), last_key);
    node = found == here.keys.end() ? -1 : here.children[static_cast<std::size_t>(found - here.keys.begin())];
    at = end + (end < path.size() && path[end] == '.' ? 1 : 0);
  }
  if (parent < 0) return no_place();
  YamlState piece;
  piece.file = where;
  const auto root = parse_yaml(value, piece);
  if (!root) return Failure(root.error());
  const int offset = static_cast<int>(state_->nodes.size());
  for (YamlNode& fresh : piece.nodes) {
    for (int& c : fresh.children) c += offset;
    fresh.line = state_->nodes[static_cast<std::size_t>(parent)].line;
    state_->nodes.push_back(std::move(fresh));
  }
  YamlNode& owner = state_->nodes[static_cast<std::size_t>(parent)];
  if (node < 0) {
    owner.keys.push_back(last_key);
    owner.children.push_back(*root + offset);
  } else {
    std::replace(owner.children.begin(), owner.children.end(), node, *root + offset);
  }
  return {};
}

}  // namespace omniflight::files
