// Distance fields kept between runs, a file each.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "omniflight_planning/map.hpp"

namespace omniflight::planning {

inline constexpr std::uintmax_t kFieldCacheBytes = 256u << 20;  // of all files; the oldest are removed

/// A field as its file tells it.
struct StoredField {
  std::array<int, 3> size{};
  Vec3 lower = Vec3::Zero();  ///< m
  double resolution = 0.0;    ///< m
  std::vector<float> field;   ///< m
};

/// A file's name tells what its field depends on: the map's hash (the resolution is in the map), the version
/// of the format, the policy for unknown space and where distances are cut off.
std::filesystem::path field_file(const std::filesystem::path& folder, const std::string& map_sha256,
                                 const MapOptions& options);

/// Nothing where there is no such file, or once the deadline has passed. A file whose hash, size or numbers
/// do not agree is an error.
Result<std::optional<StoredField>> read_field(const std::filesystem::path& file, const MapOptions& options);

/// Writes a temporary and renames it, then removes the oldest fields beyond `most` bytes. A folder that
/// cannot be written costs time later, no plan: nothing is reported.
void write_field(const std::filesystem::path& file, const StoredField& field,
                 std::uintmax_t most = kFieldCacheBytes);

}  // namespace omniflight::planning
