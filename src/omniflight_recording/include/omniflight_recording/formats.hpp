// Loading of recordings: the format is recognised by content, never by name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

struct LoadOptions {
  /// YAML that says which columns of a foreign CSV, or which topics of a bag or ULog, are which signals
  /// (README, "Maps"); empty for none.
  std::filesystem::path map;
  std::size_t max_bytes = std::size_t{2} << 30;  ///< larger files are refused
};

/// One supported format. `sniff` sees the first 64 kB; `read` the whole, inflated when it was gzipped.
struct Format {
  const char* name;
  const char* description;
  bool (*sniff)(std::string_view head);
  Result<Recording> (*read)(std::string_view bytes, const std::string& file, const LoadOptions& options);
};
const std::vector<Format>& formats();

/// Reads any supported file (also gzipped), or the files of a rosbag2 folder (MCAP or SQLite) as one
/// recording, whose hash is that of the hashes of its parts. A damaged or cut file is read as far as it is
/// sound, and what is lost stands in the notes; an empty or unusable file is an error that names it, and an
/// unknown one an error that also names what converts it, where that is known.
Result<Recording> load(const std::filesystem::path& path, const LoadOptions& options = {});

/// Writes the canonical CSV of all signals (empty cells where a signal has no sample), whole or not at all.
Status write_csv(const Recording& recording, const std::filesystem::path& path);
/// The same as text.
std::string to_csv(const Recording& recording);

}  // namespace omniflight::recording
