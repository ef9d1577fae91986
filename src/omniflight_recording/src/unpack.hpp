// Decompression into a string whose size is told before; nothing is allocated beyond it.
#pragma once

#include <string>
#include <string_view>

namespace omniflight::recording {

/// One lz4 frame. True when exactly out.size() bytes came out.
bool unpack_lz4(std::string_view in, std::string& out);
/// One bzip2 stream. True when exactly out.size() bytes came out.
bool unpack_bz2(std::string_view in, std::string& out);

/// One zstd frame that tells its size, which may be `most` bytes; nothing otherwise.
inline constexpr std::string_view kZstdMagic{"\x28\xb5\x2f\xfd", 4};
bool unpack_zstd(std::string_view in, std::size_t most, std::string& out);

}  // namespace omniflight::recording
