// Layout of ULog records, and whether bytes look like one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "byte_cursor.hpp"

namespace omniflight::recording::ulog {

inline constexpr std::string_view kMagic{"ULog\x01\x12\x35", 7};
inline constexpr std::size_t kHeaderBytes = 16, kRecordHead = 3;
inline constexpr std::string_view kSync{"\x2f\x73\x13\x20\x25\x0c\xbb\x12", 8};

struct Record {
  char type = 0;
  std::string_view body;
};

/// The record at this byte; nothing where the file, or `end`, comes before its end.
std::optional<Record> record_at(std::string_view bytes, std::size_t at, std::size_t end);

/// A key with its type and value: "float NAME", or "char[5] sys_name".
struct KeyValue {
  std::string_view type, name, value;
};
/// Of an I or P record; `skip` bytes come before (M and Q records have one).
std::optional<KeyValue> key_value(std::string_view body, std::size_t skip);

/// The number of a value by its type ("float", "int32_t", ...); nothing for text and unknown types.
std::optional<double> number_of(std::string_view type, std::string_view value);

/// Whether the body fits the type, as far as that can be said without knowing the formats: D records are held
/// against their format by the reader.
bool fits_its_type(const Record& record);

/// Types that the format knows.
bool is_known(char type);

}  // namespace omniflight::recording::ulog
