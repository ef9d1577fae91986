#include "omniflight_recording/formats.hpp"

#include "format_table.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {

const std::vector<Format>& formats() {
  static const std::vector<Format> table{mcap_format(), ulog_format(), microsd_format(), csv_format()};
  return table;
}

namespace {

/// The recording in a rosbag2 folder: its one file. Bags that were split into several are not joined.
Result<std::filesystem::path> file_of_bag(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code ec;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, ec))
    if (entry.path().extension() == ".mcap") found.push_back(entry.path());
  if (found.size() == 1) return found.front();
  return bad_input(found.empty() ? "is a folder without an MCAP file"
                                 : "is a folder of " + std::to_string(found.size()) + " MCAP files",
                   folder.string(), "Give the file itself");
}

}  // namespace

Result<Recording> load(const std::filesystem::path& given, const LoadOptions& options) {
  std::filesystem::path path = given;
  if (std::error_code ec; std::filesystem::is_directory(given, ec)) {
    const auto inside = file_of_bag(given);
    if (!inside) return Failure(inside.error());
    path = *inside;
  }
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
