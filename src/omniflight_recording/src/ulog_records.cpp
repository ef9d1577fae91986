#include "ulog_records.hpp"

#include <algorithm>
#include <charconv>

namespace omniflight::recording::ulog {
namespace {

constexpr std::size_t kLongestText = 4096;

bool printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

std::size_t size_of(std::string_view type) {
  if (type == "int8_t" || type == "uint8_t" || type == "bool" || type == "char") return 1;
  if (type == "int16_t" || type == "uint16_t") return 2;
  if (type == "int32_t" || type == "uint32_t" || type == "float") return 4;
  if (type == "int64_t" || type == "uint64_t" || type == "double") return 8;
  return 0;
}

/// Whether a value has the size of its type: "char[5]" has five bytes.
bool sized(const KeyValue& kv) {
  std::uint64_t count = 1;
  std::string_view type = kv.type;
  if (const auto bracket = type.find('['); bracket != std::string_view::npos) {
    const auto r = std::from_chars(type.data() + bracket + 1, type.data() + type.size(), count);
    if (r.ec != std::errc() || count > 65535 || r.ptr + 1 != type.data() + type.size()) return false;
    type = type.substr(0, bracket);
  }
  const std::size_t one = size_of(type);
  return one > 0 && kv.value.size() == one * count;
}

template <class T>
double get(std::string_view value) {
  return static_cast<double>(ByteCursor(value).get<T>());
}

}  // namespace

std::optional<Record> record_at(std::string_view bytes, std::size_t at, std::size_t end) {
  if (at > end || end - at < kRecordHead) return std::nullopt;
  ByteCursor c(bytes.substr(at, end - at));
  const auto size = c.get<std::uint16_t>();
  Record r;
  r.type = static_cast<char>(c.get<std::uint8_t>());
  r.body = c.take(size);
  if (!c.ok()) return std::nullopt;
  return r;
}

std::optional<KeyValue> key_value(std::string_view body, std::size_t skip) {
  if (body.size() < skip + 1) return std::nullopt;
  ByteCursor c(body.substr(skip));
  const auto key = c.take(c.get<std::uint8_t>());
  const auto blank = key.find(' ');
  if (!c.ok() || blank == 0 || blank == std::string_view::npos || blank + 1 == key.size() || !printable(key))
    return std::nullopt;
  return KeyValue{key.substr(0, blank), key.substr(blank + 1), c.take(c.left())};
}

std::optional<double> number_of(std::string_view type, std::string_view value) {
  if (value.size() != size_of(type)) return std::nullopt;
  if (type == "float") return get<float>(value);
  if (type == "double") return get<double>(value);
  if (type == "int8_t") return get<std::int8_t>(value);
  if (type == "uint8_t" || type == "bool") return get<std::uint8_t>(value);
  if (type == "int16_t") return get<std::int16_t>(value);
  if (type == "uint16_t") return get<std::uint16_t>(value);
  if (type == "int32_t") return get<std::int32_t>(value);
  if (type == "uint32_t") return get<std::uint32_t>(value);
  if (type == "int64_t") return get<std::int64_t>(value);
  if (type == "uint64_t") return get<std::uint64_t>(value);
  return std::nullopt;
}

bool is_known(char type) { return std::string_view("BFIMPQARDLCSO").find(type) != std::string_view::npos; }

bool fits_its_type(const Record& r) {
  switch (r.type) {
    case 'B':
      return r.body.size() >= 40;
    case 'F':
      return r.body.size() > 2 && r.body.find(':') != std::string_view::npos && printable(r.body);
    case 'I': {
      const auto kv = key_value(r.body, 0);
      return kv && sized(*kv);
    }
    case 'M':
      return key_value(r.body, 1).has_value();  // a value may go on in further records
    case 'P':
    case 'Q': {
      const auto kv = key_value(r.body, r.type == 'Q' ? 1 : 0);
      return kv && (kv->type == "float" || kv->type == "int32_t") && kv->value.size() == 4;
    }
    case 'A':
      return r.body.size() > 3 && printable(r.body.substr(3));
    case 'R':
    case 'O':
      return r.body.size() == 2;
    case 'D':
      return r.body.size() >= 2 + 8;
    case 'L':
      return r.body.size() >= 9 && r.body.size() <= 9 + kLongestText && r.body[0] >= '0' && r.body[0] <= '7';
    case 'C':
      return r.body.size() >= 11 && r.body.size() <= 11 + kLongestText && r.body[0] >= '0' &&
             r.body[0] <= '7';
    case 'S':
      return r.body == kSync;
    default:
      return false;
  }
}

}  // namespace omniflight::recording::ulog
