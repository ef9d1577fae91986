// Files of unknown origin: every read is capped, every write is whole or absent.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "omniflight_core/result.hpp"

namespace omniflight::files {

inline constexpr std::size_t kMegabyte = 1u << 20;

/// Whole content of a regular file of at most max_bytes. The error names the file, its size and the limit.
Result<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes);

/// As read_file, and when the content starts with the gzip magic it is inflated; max_bytes caps the result.
/// A truncated or corrupt gzip stream is an error.
Result<std::string> read_gzip_or_plain(const std::filesystem::path& path, std::size_t max_bytes);

/// Inflates a gzip stream held in memory; `name` is used in errors. Its size is counted before anything is
/// kept, and counting stops at max_bytes, or where more than kSmallEnough has come out at more than
/// kMostGzipRatio bytes a byte.
inline constexpr std::size_t kSmallEnough = 32 * kMegabyte;
inline constexpr std::size_t kMostGzipRatio = 100;  ///< logs come to 3 to 40; deflate can do 1032
Result<std::string> gunzip(std::string_view bytes, std::size_t max_bytes, const std::string& name);

/// Writes content beside the path, syncs it and renames it over the path: after an error (full disk, missing
/// folder) the old file is untouched and nothing half-written is left. Refuses devices, pipes and folders.
Status write_file_atomic(const std::filesystem::path& path, std::string_view content);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

/// SHA-256 of a file of any size, read in blocks.
Result<std::string> sha256_file(const std::filesystem::path& path);

/// The folder `configs`: $OMNIFLIGHT_CONFIGS (an error if it is none), else the first with `vehicles` above
/// the running program, above the working directory, or as omniflight/configs in $XDG_DATA_DIRS.
Result<std::filesystem::path> config_dir();

/// Text of unknown origin made fit for an error message: quoted, printable, at most 60 characters.
std::string shown(std::string_view text);

/// The candidate nearest to `word` by edit distance, empty when nothing is near.
template <class Range>
std::string nearest_word(std::string_view word, const Range& candidates);

/// Number of single-character edits between two words (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b);

template <class Range>
std::string nearest_word(std::string_view word, const Range& candidates) {
  std::string best;
  std::size_t best_distance = word.size() / 3 + 2;
  for (const auto& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = std::string(candidate);
    }
  }
  return best;
}

}  // namespace omniflight::files
