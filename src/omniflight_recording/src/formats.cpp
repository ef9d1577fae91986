#include "omniflight_recording/formats.hpp"

#include "format_table.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {

const std::vector<Format>& formats() {
  static const std::vector<Format> table{mcap_format(), microsd_format(), csv_format()};
  return table;
}

Result<Recording> load(const std::filesystem::path& path, const LoadOptions& options) {
  auto bytes = files::read_file(path, options.max_bytes);
  if (!bytes) return Failure(bytes.error());
  const std::string hash = files::sha256_hex(*bytes);
  if (bytes->size() >= 2 && bytes->compare(0, 2, "\x1f\x8b") == 0) {
    bytes = files::gunzip(*bytes, options.max_bytes, path.string());
    if (!bytes) return Failure(bytes.error());
  }
  if (bytes->empty()) return bad_input("is empty", path.string(), "Give a recording");
  const std::string_view head = std::string_view(*bytes).substr(0, 1 << 16);
  for (const Format& format : formats()) {
    if (!format.sniff(head)) continue;
    auto recording = format.read(*bytes, path.string(), options);
    if (!recording) return recording;
    recording->file = path.string();
    recording->format = format.name;
    recording->sha256 = hash;
    return recording;
  }
  std::string known;
  for (const Format& format : formats())
    known += (known.empty() ? "" : "; ") + std::string(format.description);
  return bad_input("is not a recording of a known format", path.string(), "Known formats: " + known);
}

}  // namespace omniflight::recording
