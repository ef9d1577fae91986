#include "omniflight_recording/formats.hpp"

#include <algorithm>
#include <cstdlib>

#include "format_table.hpp"
#include "frame_evidence.hpp"
#include "join.hpp"
#include "omniflight_files/files.hpp"
#include "other_formats.hpp"

namespace omniflight::recording {

const std::vector<Format>& formats() {
  static const std::vector<Format> table{mcap_format(),    ulog_format(),    rosbag1_format(),
                                         rosbag2_format(), microsd_format(), genom3_format(),
                                         csv_format()};
  return table;
}

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxParts = 10000;

/// "bag_10.db3" -> ("bag_", 10): parts are numbered, and 10 comes after 9.
std::pair<std::string, long> numbered(const fs::path& file) {
  const std::string stem = file.stem().string();
  const auto digits = stem.find_last_not_of("0123456789") + 1;
  return {stem.substr(0, digits), std::strtol(stem.c_str() + digits, nullptr, 10)};
}

/// The parts of a recording in a rosbag2 folder, in order.
Result<std::vector<fs::path>> parts_of_bag(const fs::path& folder) {
  std::error_code ec;
  std::vector<fs::path> mcap, sqlite;
  for (const auto& entry : fs::directory_iterator(folder, ec)) {
    if (entry.path().extension() == ".mcap") mcap.push_back(entry.path());
    if (entry.path().extension() == ".db3") sqlite.push_back(entry.path());
    if (mcap.size() + sqlite.size() > kMaxParts) break;
  }
  std::vector<fs::path>& parts = mcap.empty() ? sqlite : mcap;
  if (parts.empty() || (!mcap.empty() && !sqlite.empty()) || parts.size() > kMaxParts)
    return bad_input(parts.empty() ? "is a folder without a ROS 2 bag (.mcap or .db3)"
                                   : "is a folder with more than one ROS 2 bag",
                     folder.string(), "Give the file itself");
  std::sort(parts.begin(), parts.end(),
            [](const fs::path& a, const fs::path& b) { return numbered(a) < numbered(b); });
  for (const fs::path& part : parts)
    if (numbered(part).first != numbered(parts.front()).first)
      return bad_input("is a folder with several recordings", folder.string(), "Give the file itself");
  return parts;
}

Result<Recording> load_file(const fs::path& path, const LoadOptions& options) {
  auto bytes = files::read_file(path, options.max_bytes);
  if (!bytes) return Failure(bytes.error());
  const std::string hash = files::sha256_hex(*bytes);
  if (bytes->size() >= 2 && bytes->compare(0, 2, "\x1f\x8b") == 0) {
    bytes = files::gunzip(*bytes, options.max_bytes, path.string());
    if (!bytes) return Failure(bytes.error());
  }
  if (bytes->empty()) return bad_input("is empty", path.string(), "Give a recording");
  const std::string_view head = std::string_view(*bytes).substr(0, 1 << 16);
  if (const OtherFormat* other = find_other_format(head))
    return bad_input(std::string("is ") + other->name + ", which is not read", path.string(),
                     other->conversion);
  for (const Format& format : formats()) {
    if (!format.sniff(head)) continue;
    auto recording = format.read(*bytes, path.string(), options);
    if (!recording) return recording;
    recording->file = path.string();
    recording->format = format.name;
    recording->sha256 = hash;
    const bool ours = recording->metadata.contains("mcap.library") &&
                      recording->metadata.at("mcap.library") == "omniflight";
    if (!ours && !recording->topics.empty()) note_frame_evidence(*recording);
    return recording;
  }
  std::string known;
  for (const Format& format : formats())
    known += (known.empty() ? "" : "; ") + std::string(format.description);
  return bad_input("is not a recording of a known format", path.string(), "Known formats: " + known);
}

}  // namespace

Result<Recording> load(const std::filesystem::path& given, const LoadOptions& options) {
  std::error_code ec;
  if (!fs::is_directory(given, ec)) return load_file(given, options);
  const auto parts = parts_of_bag(given);
  if (!parts) return Failure(parts.error());
  auto whole = load_file(parts->front(), options);
  if (!whole || parts->size() == 1) return whole;
  std::string hashes = whole->sha256;
  for (std::size_t i = 1; i < parts->size(); ++i) {
    auto part = load_file((*parts)[i], options);
    if (!part) return part;
    hashes += part->sha256;
    append_part(*whole, std::move(*part), (*parts)[i].filename().string());
  }
  whole->file = given.string();
  whole->sha256 = files::sha256_hex(hashes);
  whole->metadata["parts"] = std::to_string(parts->size());
  return whole;
}

}  // namespace omniflight::recording
