#include "mcap_chunk.hpp"

#include <zstd.h>

#include "mcap_records.hpp"
#include "unpack.hpp"

namespace omniflight::recording::mcap {
namespace {

constexpr std::uint64_t kMaxChunk = 256u << 20;

}  // namespace

std::optional<ChunkHeader> read_chunk_header(std::string_view content) {
  ByteCursor c(content);
  ChunkHeader h;
  h.first_ns = c.get<std::uint64_t>();
  h.last_ns = c.get<std::uint64_t>();
  h.uncompressed = c.get<std::uint64_t>();
  h.crc = c.get<std::uint32_t>();
  h.compression = c.string();
  h.records = c.take(c.get<std::uint64_t>());
  const bool known = h.compression.empty() || h.compression == "zstd" || h.compression == "lz4";
  if (!c.ok() || !known || h.first_ns > h.last_ns || h.uncompressed > kMaxChunk) return std::nullopt;
  return h;
}

std::string unpack_chunk(const ChunkHeader& chunk, std::string& out) {
  if (chunk.compression.empty()) {
    if (chunk.records.size() != chunk.uncompressed) return "its size is wrong";
    out.assign(chunk.records);
  } else {
    // A ratio no compressor of log data reaches is a bomb; both formats can at best repeat 255 bytes per byte
    // (lz4) or one block of 128 kB per 4 bytes (zstd).
    if (chunk.uncompressed > 65536 + chunk.records.size() * 40000) return "its size is implausible";
    out.resize(static_cast<std::size_t>(chunk.uncompressed));
    if (chunk.compression == "lz4") {
      if (!unpack_lz4(chunk.records, out)) return "it cannot be decompressed (lz4)";
    } else {
      const std::size_t n =
          ZSTD_decompress(out.data(), out.size(), chunk.records.data(), chunk.records.size());
      if (ZSTD_isError(n) || n != out.size()) return "it cannot be decompressed (zstd)";
    }
  }
  if (chunk.crc != 0 && crc32_of(out) != chunk.crc) return "its CRC32 does not match";
  return {};
}

}  // namespace omniflight::recording::mcap
