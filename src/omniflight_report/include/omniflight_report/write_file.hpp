// Files that are whole or not there.
#pragma once

#include <filesystem>
#include <string_view>

#include "omniflight_core/result.hpp"

namespace omniflight::report {

/// Writes a temporary file beside path, syncs it and renames it. On an error (full disk, missing directory)
/// the old file stays as it was and nothing is left behind. A path that is a device or a pipe is written
/// directly.
Status write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace omniflight::report
