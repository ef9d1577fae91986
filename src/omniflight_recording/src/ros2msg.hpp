// Decodes XCDR1 messages by the ros2msg text that the recording itself carries.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "byte_cursor.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::recording {

/// The numbers of the wanted fields of one message type.
class CdrDecoder {
 public:
  /// `type` is "pkg/msg/Name" or "pkg/Name"; `wanted` are paths such as "header.stamp.sec" or "velocity" (a
  /// number or an array of numbers). A wanted field that the type does not have stays empty in every message.
  static Result<CdrDecoder> create(const std::string& type, const std::string& schema_text,
                                   const std::vector<std::string>& wanted);

  /// Numbers of wanted[i] in out[i]. False when the message is cut, too long or not plain XCDR1.
  bool decode(std::string_view cdr, std::vector<std::vector<double>>& out) const;

  /// Whether the type has the field wanted[i].
  bool has(std::size_t i) const { return found_[i]; }

 private:
  enum class Kind : std::uint8_t {
    b,
    i8,
    u8,
    i16,
    u16,
    i32,
    u32,
    i64,
    u64,
    f32,
    f64,
    string,
    wstring,
    record
  };
  struct Field {
    Kind kind = Kind::u8;
    int record = -1;  // index into records_, for Kind::record
    bool array = false;
    std::uint32_t fixed = 0;  // length of a fixed array; 0 = sequence with a length in front
    int slot = -1;            // index of the wanted path
  };
  struct Reader;
  bool read_record(Reader& in, int record, std::vector<std::vector<double>>& out, int depth) const;
  bool read_field(Reader& in, const Field& field, std::vector<std::vector<double>>& out, int depth) const;

  std::vector<std::vector<Field>> records_;  // one per path of use, so that slots are unique
  std::vector<bool> found_;
  friend struct SchemaBuilder;
};

}  // namespace omniflight::recording
