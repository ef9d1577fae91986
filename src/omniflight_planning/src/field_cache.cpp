#include "field_cache.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <vector>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/octree_file.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".field";
constexpr char kFormat[8] = "OFFLD1";         // a change of the format changes it
constexpr std::uint32_t kOrder = 0x01020304;  // of the bytes of numbers
constexpr std::size_t kHashChars = 64;        // SHA-256 of everything after it, in hexadecimal

struct CacheHeader {
  char format[8];
  std::uint32_t order;
  std::int32_t size[3];
  double lower[3], resolution;
};
static_assert(sizeof(CacheHeader) == 56 && std::is_trivially_copyable_v<CacheHeader>);

Failure damaged(const fs::path& file, const char* why) {
  return bad_input(std::string("the kept distance field ") + why, file.string(), "It is computed again");
}

}  // namespace

fs::path field_cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache == '/') return fs::path(cache) / "omniflight";
  const char* home = std::getenv("HOME");
  return home != nullptr && *home == '/' ? fs::path(home) / ".cache" / "omniflight" : fs::path();
}

fs::path field_file(const fs::path& folder, const std::string& map_sha256, const MapOptions& options) {
  return folder / (files::sha256_hex(text("%s %s %s %.17g", kFormat, map_sha256.c_str(),
                                          options.unknown == UnknownSpace::occupied ? "occupied" : "free",
                                          options.max_distance)) +
                   kSuffix);
}

Result<std::optional<StoredField>> read_field(const fs::path& file, const MapOptions& options) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::optional<StoredField>();
  const auto bytes = files::read_file(file, kHashChars + sizeof(CacheHeader) + kMaxMapVoxels * sizeof(float));
  if (!bytes) return damaged(file, "cannot be read");
  if (options.deadline.passed()) return std::optional<StoredField>();
  if (bytes->size() < kHashChars + sizeof(CacheHeader)) return damaged(file, "is truncated");
  const std::string_view rest = std::string_view(*bytes).substr(kHashChars);
  if (files::sha256_hex(rest) != std::string_view(*bytes).substr(0, kHashChars))
    return damaged(file, "does not have its hash");
  if (options.deadline.passed()) return std::optional<StoredField>();
  CacheHeader h;
  std::memcpy(&h, rest.data(), sizeof h);
  if (std::memcmp(h.format, kFormat, sizeof h.format) != 0 || h.order != kOrder)
    return damaged(file, "has another format");
  StoredField out;
  std::uint64_t voxels = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    if (h.size[k] < 1 || static_cast<std::uint64_t>(h.size[k]) > kMaxMapVoxels / voxels)
      return damaged(file, "has no size that a map may have");
    voxels *= static_cast<std::uint64_t>(h.size[k]);
    out.size[k] = h.size[k];
  }
  out.lower = Vec3(h.lower[0], h.lower[1], h.lower[2]);
  out.resolution = h.resolution;
  if (rest.size() != sizeof h + voxels * sizeof(float)) return damaged(file, "does not have its size");
  if (!out.lower.allFinite() || out.lower.cwiseAbs().maxCoeff() > 1e6 ||
      !(h.resolution >= 1e-3 && h.resolution <= 10.0))
    return damaged(file, "lies nowhere");
  out.field.resize(voxels);
  std::memcpy(out.field.data(), rest.data() + sizeof h, voxels * sizeof(float));
  const auto most = static_cast<float>(options.max_distance);
  if (!std::all_of(out.field.begin(), out.field.end(), [&](float d) { return d >= 0.0f && d <= most; }))
    return damaged(file, "holds what is no distance");
  return std::optional(std::move(out));
}

void write_field(const fs::path& file, const StoredField& field, std::uintmax_t most) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) return;
  CacheHeader h{};
  std::memcpy(h.format, kFormat, sizeof h.format);
  h.order = kOrder;
  for (std::size_t k = 0; k < 3; ++k)
    h.size[k] = field.size[k], h.lower[k] = field.lower[static_cast<int>(k)];
  h.resolution = field.resolution;
  std::string bytes(kHashChars + sizeof h + field.field.size() * sizeof(float), '\0');
  std::memcpy(bytes.data() + kHashChars, &h, sizeof h);
  std::memcpy(bytes.data() + kHashChars + sizeof h, field.field.data(), field.field.size() * sizeof(float));
  const std::string hash = files::sha256_hex(std::string_view(bytes).substr(kHashChars));
  std::memcpy(bytes.data(), hash.data(), kHashChars);
  if (!files::write_file_atomic(file, bytes)) return;

  struct Kept {
    fs::file_time_type when;
    std::uintmax_t bytes;
    fs::path path;
  };
  std::vector<Kept> kept;
  for (fs::directory_iterator at(file.parent_path(), error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;  // another run may remove it meanwhile
    if (at->path().extension() != kSuffix || !at->is_regular_file(gone)) continue;
    const auto when = at->last_write_time(gone);
    const auto size = at->file_size(gone);
    if (!gone) kept.push_back({when, size, at->path()});
  }
  std::sort(kept.begin(), kept.end(), [](const Kept& a, const Kept& b) { return a.when > b.when; });
  std::uintmax_t sum = 0;
  for (const Kept& one : kept)
    if ((sum += one.bytes) > most && one.path != file) fs::remove(one.path, error);
}

}  // namespace omniflight::planning
