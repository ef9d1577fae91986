#include "ros2msg.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

struct RawField {
  std::string type, name;
  bool array = false;
  std::uint32_t fixed = 0;
};
using RawTypes = std::map<std::string, std::vector<RawField>>;

std::string_view next_word(std::string_view& line) {
  const auto begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return line = {};
  const auto end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const auto word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// "pkg/msg/Name" -> "pkg/Name".
std::string short_name(std::string name) {
  if (const auto at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

/// "float64[6]", "string<=10[<=3]", "geometry_msgs/Point[]".
std::optional<RawField> parse_type(std::string_view text) {
  RawField f;
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

std::optional<RawTypes> parse_schema(const std::string& root, std::string_view text) {
  RawTypes types;
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
      current = short_name(std::string(next_word(line)));
      types[current].clear();
      continue;
    }
    const auto name = next_word(line);
    if (name.empty()) return std::nullopt;
    if (name.find('=') != std::string_view::npos || next_word(line).substr(0, 1) == "=")
      continue;  // constant
    auto field = parse_type(type);
    if (!field || types[current].size() > 1000) return std::nullopt;
    field->name = std::string(name);
    types[current].push_back(std::move(*field));
  }
  return types;
}

}  // namespace

struct SchemaBuilder {
  using Kind = CdrDecoder::Kind;
  const RawTypes& types;
  const std::vector<std::string>& wanted;
  CdrDecoder& decoder;
  std::string error = {};

  static std::optional<Kind> primitive(const std::string& name) {
    static const std::map<std::string, Kind> table{
        {"bool", Kind::b},      {"byte", Kind::u8},       {"char", Kind::u8},        {"int8", Kind::i8},
        {"uint8", Kind::u8},    {"int16", Kind::i16},     {"uint16", Kind::u16},     {"int32", Kind::i32},
        {"uint32", Kind::u32},  {"int64", Kind::i64},     {"uint64", Kind::u64},     {"float32", Kind::f32},
        {"float64", Kind::f64}, {"string", Kind::string}, {"wstring", Kind::wstring}};
    const auto found = table.find(name);
    return found == table.end() ? std::nullopt : std::optional(found->second);
  }

  /// Builds the record of `type` as used at `path`; returns its index, or -1 with `error` set.
  int build(const std::string& type, const std::string& path, int depth) {
    if (depth > 32 || decoder.records_.size() > 2000) {
      error = "its types nest too deeply";
      return -1;
    }
    const auto found = types.find(type);
    if (found == types.end()) {
      error = "type " + files::shown(type) + " is not defined";
      return -1;
    }
    const int index = static_cast<int>(decoder.records_.size());
    decoder.records_.emplace_back();
    std::vector<CdrDecoder::Field> fields;
    for (const RawField& raw : found->second) {
      const std::string here = path.empty() ? raw.name : path + "." + raw.name;
      CdrDecoder::Field f;
      f.array = raw.array;
      f.fixed = raw.fixed;
      if (const auto kind = primitive(raw.type)) {
        f.kind = *kind;
        const auto slot = std::find(wanted.begin(), wanted.end(), here);
        if (slot != wanted.end()) {
          f.slot = static_cast<int>(slot - wanted.begin());
          decoder.found_[static_cast<std::size_t>(f.slot)] = true;
        }
      } else {
        f.kind = Kind::record;
        std::string name = short_name(raw.type);
        if (name == "Header" || name == "time" || name == "duration")
          name = name == "Header" ? "std_msgs/Header"
                                  : "builtin_interfaces/" + std::string(name == "time" ? "Time" : "Duration");
        if (name.find('/') == std::string::npos) name = type.substr(0, type.find('/') + 1) + name;
        f.record = build(name, here, depth + 1);
        if (f.record < 0) return -1;
      }
      fields.push_back(f);
    }
    decoder.records_[static_cast<std::size_t>(index)] = std::move(fields);
    return index;
  }
};

Result<CdrDecoder> CdrDecoder::create(const std::string& type, const std::string& schema_text,
                                      const std::vector<std::string>& wanted) {
  if (schema_text.size() > (1u << 20)) return bad_input("the message definition is larger than 1 MB", type);
  const std::string root = short_name(type);
  const auto types = parse_schema(root, schema_text);
  if (!types) return bad_input("the message definition cannot be parsed", type);
  CdrDecoder decoder;
  decoder.found_.assign(wanted.size(), false);
  SchemaBuilder builder{*types, wanted, decoder};
  if (builder.build(root, "", 0) < 0)
    return bad_input("the message definition cannot be used: " + builder.error, type);
  return decoder;
}

/// Alignment counts from the byte behind the encapsulation header.
struct CdrDecoder::Reader {
  ByteCursor cursor;
  bool swap;

  template <class T>
  T number() {
    cursor.take((sizeof(T) - cursor.at() % sizeof(T)) % sizeof(T));
    T value = cursor.get<T>();
    if (swap) {
      char* bytes = reinterpret_cast<char*>(&value);
      std::reverse(bytes, bytes + sizeof(T));
    }
    return value;
  }
  double value(Kind kind) {
    switch (kind) {
      case Kind::b:
      case Kind::u8:
        return number<std::uint8_t>();
      case Kind::i8:
        return number<std::int8_t>();
      case Kind::i16:
        return number<std::int16_t>();
      case Kind::u16:
        return number<std::uint16_t>();
      case Kind::i32:
        return number<std::int32_t>();
      case Kind::u32:
        return number<std::uint32_t>();
      case Kind::i64:
        return static_cast<double>(number<std::int64_t>());
      case Kind::u64:
        return static_cast<double>(number<std::uint64_t>());
      case Kind::f32:
        return static_cast<double>(number<float>());
      default:
        return number<double>();
    }
  }
};

bool CdrDecoder::read_field(Reader& in, const Field& f, std::vector<std::vector<double>>& out,
                            int depth) const {
  std::uint32_t count = 1;
  if (f.array) count = f.fixed > 0 ? f.fixed : in.number<std::uint32_t>();
  if (!in.cursor.ok() || count > in.cursor.left() + 1) return false;  // every element takes at least a byte
  for (std::uint32_t i = 0; i < count; ++i) {
    if (f.kind == Kind::record) {
      if (!read_record(in, f.record, out, depth + 1)) return false;
    } else if (f.kind == Kind::string) {
      in.cursor.take(in.number<std::uint32_t>());
    } else if (f.kind == Kind::wstring) {
      in.cursor.take(std::uint64_t{4} * in.number<std::uint32_t>());
    } else {
      const double value = in.value(f.kind);
      if (f.slot >= 0) out[static_cast<std::size_t>(f.slot)].push_back(value);
    }
    if (!in.cursor.ok()) return false;
  }
  return true;
}

bool CdrDecoder::read_record(Reader& in, int record, std::vector<std::vector<double>>& out, int depth) const {
  if (depth > 32) return false;
  const auto& fields = records_[static_cast<std::size_t>(record)];
  if (fields.empty()) in.cursor.get<std::uint8_t>();  // ROS gives an empty message one byte
  for (const Field& f : fields)
    if (!read_field(in, f, out, depth)) return false;
  return in.cursor.ok();
}

bool CdrDecoder::decode(std::string_view cdr, std::vector<std::vector<double>>& out) const {
  out.resize(found_.size());
  for (auto& numbers : out) numbers.clear();
  if (cdr.size() < 4 || cdr[0] != 0 || (cdr[1] != 0 && cdr[1] != 1)) return false;
  Reader in{ByteCursor(cdr.substr(4)), cdr[1] == 0};
  return read_record(in, 0, out, 0) && in.cursor.left() < 8;  // at most padding is left
}

}  // namespace omniflight::recording
