// Decodes messages by the definition that the recording itself carries.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "byte_cursor.hpp"
#include "message_definition.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::recording {

/// How the numbers of a message lie in its bytes.
enum class Encoding {
  xcdr1,  ///< ROS 2: encapsulation header, aligned values
  ros1,   ///< ROS 1: little endian, packed
  ulog    ///< PX4: as ros1; a message may end before the padding at its end
};

/// The numbers of the wanted fields of one message type.
class MessageDecoder {
 public:
  /// `type` is "pkg/msg/Name", "pkg/Name", or the name of a ULog format; `wanted` are paths such as
  /// "header.stamp.sec" or "velocity" (a number or an array of numbers; "esc.rpm" also where esc is an array
  /// of records). A wanted field that the type does not have stays empty in every message.
  static Result<MessageDecoder> create(const std::string& type, const MessageTypes& types,
                                       const std::vector<std::string>& wanted, Encoding encoding);

  /// Numbers of wanted[i] in out[i]. False when the message is cut, too long or encoded in another way.
  bool decode(std::string_view message, std::vector<std::vector<double>>& out) const;

  /// Whether the type has the field wanted[i].
  bool has(std::size_t i) const { return found_[i]; }

  /// Bytes of the shortest message, without padding at the end. Of a ULog message every one has these.
  std::uint64_t least_bytes() const { return sizes_.front(); }
  /// Bytes of padding at the end, which a ULog message may have or not.
  std::uint64_t padding() const { return padding_; }

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
  void measure();
  std::uint64_t least_bytes_of(const Field& field) const;
  static std::size_t size_of(Kind kind);

  std::vector<std::vector<Field>> records_;  // one per path of use, so that slots are unique
  std::vector<std::uint64_t> sizes_;         // of the shortest value of each record, without alignment
  std::vector<bool> found_;
  Encoding encoding_ = Encoding::xcdr1;
  std::uint64_t padding_ = 0;
  friend struct DecoderBuilder;
};

}  // namespace omniflight::recording
