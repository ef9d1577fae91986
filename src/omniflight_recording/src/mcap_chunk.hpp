// One MCAP chunk: header fields and checked decompression.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "byte_cursor.hpp"

namespace omniflight::recording::mcap {

struct ChunkHeader {
  std::uint64_t first_ns = 0, last_ns = 0, uncompressed = 0;
  std::uint32_t crc = 0;
  std::string_view compression, records;  // records: still compressed
};

/// The header when the record is well formed.
std::optional<ChunkHeader> read_chunk_header(std::string_view content);

/// The records of a chunk into `out`; empty text when sound, otherwise what is wrong.
std::string unpack_chunk(const ChunkHeader& chunk, std::string& out);

}  // namespace omniflight::recording::mcap
