#include "unpack.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <limits>

namespace omniflight::recording {

bool unpack_lz4(std::string_view in, std::string& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
  std::size_t read = 0, written = 0, hint = 1;
  while (hint != 0 && read < in.size()) {
    std::size_t to_read = in.size() - read, to_write = out.size() - written;
    hint = LZ4F_decompress(context, out.data() + written, &to_write, in.data() + read, &to_read, nullptr);
    if (LZ4F_isError(hint) || (to_read == 0 && to_write == 0)) break;
    read += to_read;
    written += to_write;
  }
  LZ4F_freeDecompressionContext(context);
  return hint == 0 && written == out.size();
}

bool unpack_bz2(std::string_view in, std::string& out) {
  constexpr std::size_t kMost = std::numeric_limits<unsigned>::max();
  if (in.size() > kMost || out.size() > kMost) return false;
  auto size = static_cast<unsigned>(out.size());
  // the library takes the input as char*, and does not write to it
  const int result = BZ2_bzBuffToBuffDecompress(out.data(), &size, const_cast<char*>(in.data()),
                                                static_cast<unsigned>(in.size()), 0, 0);
  return result == BZ_OK && size == out.size();
}

bool unpack_zstd(std::string_view in, std::size_t most, std::string& out) {
  const auto size = ZSTD_getFrameContentSize(in.data(), in.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > most) return false;
  out.resize(static_cast<std::size_t>(size));
  return ZSTD_decompress(out.data(), out.size(), in.data(), in.size()) == size;
}

}  // namespace omniflight::recording
