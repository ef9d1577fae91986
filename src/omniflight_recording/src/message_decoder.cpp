#include "message_decoder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "omniflight_files/files.hpp"

namespace omniflight::recording {

namespace {
constexpr std::uint64_t kHugeSize = std::uint64_t{1}
                                    << 31;  // more than any message has; times a count it fits 64 bits
}

struct DecoderBuilder {
  using Kind = MessageDecoder::Kind;
  const MessageTypes& types;
  const std::vector<std::string>& wanted;
  MessageDecoder& decoder;
  std::string error = {};
  std::size_t fields_built = 0;
  static constexpr int kMaxDepth = 32;
  static constexpr std::size_t kMaxRecords = 2000, kMaxFields = 20000;

  static std::optional<Kind> primitive(const std::string& name) {
    static const std::map<std::string, Kind> table{
        {"bool", Kind::b},      {"byte", Kind::u8},       {"char", Kind::u8},        {"int8", Kind::i8},
        {"uint8", Kind::u8},    {"int16", Kind::i16},     {"uint16", Kind::u16},     {"int32", Kind::i32},
        {"uint32", Kind::u32},  {"int64", Kind::i64},     {"uint64", Kind::u64},     {"float32", Kind::f32},
        {"float64", Kind::f64}, {"string", Kind::string}, {"wstring", Kind::wstring}};
    const auto found = table.find(name);
    return found == table.end() ? std::nullopt : std::optional(found->second);
  }

  /// The name under which a type is defined that `parent` calls `raw`.
  static std::string full_name(const std::string& raw, const std::string& parent) {
    std::string name = short_type(raw);
    if (name == "Header") return "std_msgs/Header";
    if (name == "time") return "builtin_interfaces/Time";
    if (name == "duration") return "builtin_interfaces/Duration";
    if (name.find('/') == std::string::npos) name = parent.substr(0, parent.find('/') + 1) + name;
    return name;
  }

  /// Fields of a type; ROS 1 has the two of time built in.
  const std::vector<FieldDefinition>* fields_of(const std::string& type) const {
    static const std::vector<FieldDefinition> time{{"uint32", "sec", false, 0},
                                                   {"uint32", "nanosec", false, 0}};
    static const std::vector<FieldDefinition> duration{{"int32", "sec", false, 0},
                                                       {"int32", "nanosec", false, 0}};
    if (const auto found = types.find(type); found != types.end()) return &found->second;
    if (decoder.encoding_ == Encoding::ros1 && type == "builtin_interfaces/Time") return &time;
    if (decoder.encoding_ == Encoding::ros1 && type == "builtin_interfaces/Duration") return &duration;
    return nullptr;
  }

  /// Builds the record of `type` as used at `path`; returns its index, or -1 with `error` set.
  int build(const std::string& type, const std::string& path, int depth) {
    const auto* definitions = fields_of(type);
    if (!definitions) {
      error = "type " + files::shown(type) + " is not defined";
      return -1;
    }
    fields_built += definitions->size();
    if (depth > kMaxDepth || decoder.records_.size() > kMaxRecords || fields_built > kMaxFields) {
      error = "its types nest too deeply, or have too many fields";
      return -1;
    }
    const int index = static_cast<int>(decoder.records_.size());
    decoder.records_.emplace_back();
    std::vector<MessageDecoder::Field> fields;
    for (const FieldDefinition& raw : *definitions) {
      const std::string here = path.empty() ? raw.name : path + "." + raw.name;
      MessageDecoder::Field f;
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
        f.record = build(full_name(raw.type, type), here, depth + 1);
        if (f.record < 0) return -1;
      }
      fields.push_back(f);
    }
    while (depth == 0 && decoder.encoding_ == Encoding::ulog && !fields.empty() &&
           (*definitions)[fields.size() - 1].name.rfind("_padding", 0) == 0 &&
           fields.back().kind == Kind::u8) {
      decoder.padding_ += fields.back().array ? fields.back().fixed : 1;
      fields.pop_back();
    }
    decoder.records_[static_cast<std::size_t>(index)] = std::move(fields);
    return index;
  }
};

Result<MessageDecoder> MessageDecoder::create(const std::string& type, const MessageTypes& types,
                                              const std::vector<std::string>& wanted, Encoding encoding) {
  MessageDecoder decoder;
  decoder.encoding_ = encoding;
  decoder.found_.assign(wanted.size(), false);
  DecoderBuilder builder{types, wanted, decoder};
  if (builder.build(short_type(type), "", 0) < 0)
    return bad_input("the message definition cannot be used: " + builder.error, type);
  decoder.measure();
  return decoder;
}

std::size_t MessageDecoder::size_of(Kind kind) {
  switch (kind) {
    case Kind::b:
    case Kind::u8:
    case Kind::i8:
      return 1;
    case Kind::i16:
    case Kind::u16:
      return 2;
    case Kind::i32:
    case Kind::u32:
    case Kind::f32:
    case Kind::string:  // its length
    case Kind::wstring:
      return 4;
    default:
      return 8;
  }
}

std::uint64_t MessageDecoder::least_bytes_of(const Field& f) const {
  if (f.array && f.fixed == 0) return 4;
  const std::uint64_t one =
      f.kind == Kind::record ? sizes_[static_cast<std::size_t>(f.record)] : size_of(f.kind);
  return std::min(kHugeSize, one * (f.array ? f.fixed : 1));
}

void MessageDecoder::measure() {
  sizes_.assign(records_.size(), 0);
  for (std::size_t i = records_.size(); i-- > 0;) {  // a record stands before those that it is made of
    for (const Field& f : records_[i]) sizes_[i] = std::min(kHugeSize, sizes_[i] + least_bytes_of(f));
    if (records_[i].empty() && encoding_ == Encoding::xcdr1)
      sizes_[i] = 1;  // ROS 2 gives an empty message one byte
  }
}

/// Alignment counts from the byte behind the encapsulation header.
struct MessageDecoder::Reader {
  ByteCursor cursor;
  bool aligned, swap;

  void align(std::size_t size) {
    if (aligned) cursor.take((size - cursor.at() % size) % size);
  }
  template <class T>
  T number() {
    align(sizeof(T));
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

bool MessageDecoder::read_field(Reader& in, const Field& f, std::vector<std::vector<double>>& out,
                                int depth) const {
  std::uint64_t count = 1;
  if (f.array) count = f.fixed > 0 ? f.fixed : in.number<std::uint32_t>();
  const std::uint64_t least =
      f.kind == Kind::record ? sizes_[static_cast<std::size_t>(f.record)] : size_of(f.kind);
  if (!in.cursor.ok() || count * least > in.cursor.left()) return false;  // before anything is looped over
  if (least == 0) return true;                                            // records without content
  if (f.slot < 0 && f.kind < Kind::string && count > 0) {
    in.align(size_of(f.kind));
    in.cursor.take(count * size_of(f.kind));
    return in.cursor.ok();
  }
  for (std::uint64_t i = 0; i < count; ++i) {
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

bool MessageDecoder::read_record(Reader& in, int record, std::vector<std::vector<double>>& out,
                                 int depth) const {
  if (depth > 32) return false;
  const auto& fields = records_[static_cast<std::size_t>(record)];
  if (fields.empty() && encoding_ == Encoding::xcdr1) in.cursor.get<std::uint8_t>();
  for (const Field& f : fields)
    if (!read_field(in, f, out, depth)) return false;
  return in.cursor.ok();
}

bool MessageDecoder::decode(std::string_view message, std::vector<std::vector<double>>& out) const {
  out.resize(found_.size());
  for (auto& numbers : out) numbers.clear();
  bool swap = false;
  if (encoding_ == Encoding::xcdr1) {
    if (message.size() < 4 || message[0] != 0 || (message[1] != 0 && message[1] != 1)) return false;
    swap = message[1] == 0;
    message.remove_prefix(4);
  }
  Reader in{ByteCursor(message), encoding_ == Encoding::xcdr1, swap};
  if (!read_record(in, 0, out, 0)) return false;
  switch (encoding_) {
    case Encoding::xcdr1:
      return in.cursor.left() < 8;  // at most padding is left
    case Encoding::ros1:
      return in.cursor.left() == 0;
    default:
      return in.cursor.left() == 0 || in.cursor.left() == padding_;
  }
}

}  // namespace omniflight::recording
