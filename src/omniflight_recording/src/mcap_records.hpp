// MCAP record layout: opcodes and little-endian building blocks (mcap.dev/spec).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace omniflight::recording::mcap {

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};

enum Op : std::uint8_t {
  kHeader = 0x01,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd,
  /// Ours, of the range that the format leaves to applications (readers skip it): kCheckpointMark, where the
  /// checked bytes begin (u64) and their CRC32 (u32), from the end of the checkpoint before, or the start of
  /// the file, up to this one. Schemas, channels, metadata, opcodes and lengths have no checksum of their own
  /// until the file is closed.
  kCheckpoint = 0x80
};

/// Tells our checkpoints from what other programs put under the same opcode.
inline constexpr std::string_view kCheckpointMark{"omnicrc1", 8};

/// Appends little-endian values to a byte string.
class Bytes {
 public:
  template <class T>
  Bytes& put(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& string(std::string_view s) {
    put(static_cast<std::uint32_t>(s.size()));
    text_.append(s);
    return *this;
  }
  Bytes& raw(std::string_view s) {
    text_.append(s);
    return *this;
  }
  Bytes& strings(const std::map<std::string, std::string>& values) {
    Bytes body;
    for (const auto& [key, value] : values) body.string(key).string(value);
    return string(body.text());
  }
  const std::string& text() const { return text_; }
  std::string& text() { return text_; }

 private:
  std::string text_;
};

/// Opcode, length, content.
inline std::string record(Op op, std::string_view content) {
  Bytes out;
  out.put(static_cast<std::uint8_t>(op)).put(static_cast<std::uint64_t>(content.size())).raw(content);
  return std::move(out.text());
}

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace omniflight::recording::mcap
