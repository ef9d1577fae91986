#include "omniflight_planning/octree_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "octree_advice.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kMaxHeader = 64 * 1024;
constexpr int kMaxDepth = 16;
constexpr std::string_view kBinary = "# Octomap OcTree binary file", kFull = "# Octomap OcTree file";

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// Reads the text lines up to and including "data".
Result<OctreeHeader> scan_header(std::string_view bytes, const std::string& name) {
  OctreeHeader header;
  bool id = false, size = false, resolution = false;
  std::size_t at = 0;
  for (int line_number = 1;; ++line_number) {
    const std::string_view window =
        bytes.substr(at, std::min(bytes.size() - at, kMaxHeader - std::min(at, kMaxHeader)));
    const std::size_t end = window.find('\n');
    const std::string where = name + ":" + std::to_string(line_number);
    if (end == std::string_view::npos)
      return bad_input("the header has no 'data' line within 64 kB", where, kRemakeMap);
    std::string_view line = window.substr(0, end);
    at += end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line_number == 1 && !line.starts_with(kBinary) && !line.starts_with(kFull))
      return bad_input("not an OctoMap .bt or .ot file: the first line is " + files::shown(line), where,
                       kRemakeMap);
    if (line_number == 1) header.full = line.starts_with(kFull);
    if (line.empty() || line.front() == '#') continue;
    if (line == "data") break;
    const std::size_t space = line.find(' ');
    const std::string_view key = line.substr(0, space);
    const std::string_view value =
        space == std::string_view::npos ? std::string_view{} : line.substr(space + 1);
    if (key == "id") {
      if (value != "OcTree")
        return bad_input("id is " + files::shown(value) + ", not OcTree", where, kRemakeMap);
      id = true;
    } else if (key == "size") {
      if (!parse(value, header.nodes))
        return bad_input("size " + files::shown(value) + " is not a count of nodes", where, kRemakeMap);
      size = true;
    } else if (key == "res") {
      if (!parse(value, header.resolution) || !(header.resolution >= 1e-3 && header.resolution <= 10.0))
        return bad_input("res " + files::shown(value) + " is outside [0.001, 10] m", where, kRemakeMap);
      resolution = true;
    } else {
      return bad_input("unknown header field " + files::shown(key), where, kRemakeMap);
    }
  }
  if (!id || !size || !resolution) return bad_input("the header lacks id, size or res", name, kRemakeMap);
  header.data_begin = at;
  return header;
}

/// The nodes after the header, depth first and without recursion: counted, and the box of the leaves.
class NodeScan {
 public:
  NodeScan(std::string_view file, const std::string& file_name, OctreeHeader& found)
      : bytes(file), name(file_name), header(found), at(found.data_begin) {}
  std::string_view bytes;
  const std::string& name;
  OctreeHeader& header;
  std::size_t at;
  std::uint64_t count = 0;

  Status run() {
    depth_ = 0;
    level_[0] = {};
    count = header.full ? 0 : 1;  // a full node counts itself, a binary one its children
    if (auto ok = read_node(); !ok) return ok;
    while (depth_ >= 0) {
      Level& here = level_[static_cast<std::size_t>(depth_)];
      if (here.inner == 0) {
        --depth_;
        continue;
      }
      const int child = std::countr_zero(here.inner);
      here.inner &= here.inner - 1u;
      ++depth_;
      level_[static_cast<std::size_t>(depth_)].origin = origin_of(here, child, depth_);
      if (auto ok = read_node(); !ok) return ok;
    }
    header.voxels = 1;
    for (std::size_t k = 0; k < 3; ++k) header.voxels *= upper_[k] > lower_[k] ? upper_[k] - lower_[k] : 0;
    return {};
  }

 private:
  static constexpr std::size_t kFullNode = 5;   // bytes
  using Corner = std::array<std::uint32_t, 3>;  // voxels of the finest level
  struct Level {
    unsigned inner = 0;  // bits of the inner children that are still to be read
    Corner origin{};
  };

  static Corner origin_of(const Level& parent, int child, int depth) {
    Corner out = parent.origin;
    for (std::size_t k = 0; k < 3; ++k)
      if ((static_cast<unsigned>(child) >> k & 1u) != 0) out[k] += 1u << (kMaxDepth - depth);
    return out;
  }

  Status read_node() {
    if (at + (header.full ? kFullNode : 2) > bytes.size())
      return bad_input("the file ends in the middle of node " + std::to_string(count), name, kRemakeMap);
    if (auto ok = header.full ? read_full_node() : read_binary_node(); !ok) return ok;
    if (count > header.nodes)
      return bad_input(
          "the file holds more nodes than the " + std::to_string(header.nodes) + " of its header", name,
          kRemakeMap);
    return {};
  }

  Status too_deep() const { return bad_input("the tree is deeper than 16 levels", name, kRemakeMap); }

  /// Four bytes of log-odds, and a byte that has a bit for each child there is.
  Status read_full_node() {
    float log_odds = 0.0f;
    std::memcpy(&log_odds, bytes.data() + at, sizeof log_odds);
    ++count;
    if (!std::isfinite(log_odds))
      return bad_input("the occupancy of node " + std::to_string(count) + " is not finite", name, kRemakeMap);
    Level& here = level_[static_cast<std::size_t>(depth_)];
    here.inner = static_cast<unsigned char>(bytes[at + sizeof log_odds]);
    at += kFullNode;
    if (here.inner != 0) return depth_ < kMaxDepth ? Status{} : too_deep();
    if (log_odds >= 0.0f) header.has_occupied = true;
    include(here.origin, 1u << (kMaxDepth - depth_));
    return {};
  }

  /// Two bits for each child: 0 unknown, 1 free, 2 occupied, 3 inner.
  Status read_binary_node() {
    const unsigned word = static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1])
                                                                      << 8;
    at += 2;
    Level& here = level_[static_cast<std::size_t>(depth_)];
    here.inner = 0;
    for (int child = 0; child < 8; ++child) {
      const unsigned kind = word >> (2 * child) & 3u;
      if (kind != 0) ++count;
      if (kind == 2) header.has_occupied = true;
      if (kind == 3) here.inner |= 1u << child;
      if (kind == 1 || kind == 2) include(origin_of(here, child, depth_ + 1), 1u << (kMaxDepth - depth_ - 1));
    }
    return here.inner != 0 && depth_ + 1 >= kMaxDepth ? too_deep() : Status{};
  }

  void include(const Corner& origin, std::uint32_t edge) {
    for (std::size_t k = 0; k < 3; ++k) {
      lower_[k] = std::min<std::uint64_t>(lower_[k], origin[k]);
      upper_[k] = std::max<std::uint64_t>(upper_[k], origin[k] + edge);
    }
  }

  int depth_ = 0;
  std::array<Level, kMaxDepth + 1> level_{};
  std::array<std::uint64_t, 3> lower_{1u << kMaxDepth, 1u << kMaxDepth, 1u << kMaxDepth}, upper_{};
};

}  // namespace

Result<OctreeHeader> scan_octree(std::string_view bytes, const std::string& name) {
  auto header = scan_header(bytes, name);
  if (!header) return header;
  if (header->nodes == 0)
    return bad_input("the map is empty (size 0): it would mean that there is no obstacle at all", name,
                     kRemakeMap);
  if (header->nodes > kMaxOctreeNodes)
    return bad_input("the map announces " + std::to_string(header->nodes) +
                         " nodes, more than the limit of " + std::to_string(kMaxOctreeNodes),
                     name, "Use a coarser resolution");
  NodeScan scan(bytes, name, *header);
  if (auto ok = scan.run(); !ok) return Failure(ok.error());
  const std::size_t at = scan.at;
  const std::uint64_t count = scan.count;
  if (at != bytes.size())
    return bad_input(std::to_string(bytes.size() - at) + " bytes follow the last node", name, kRemakeMap);
  if (count != header->nodes)
    return bad_input("the file holds " + std::to_string(count) + " nodes, its header says " +
                         std::to_string(header->nodes),
                     name, kRemakeMap);
  if (!header->has_occupied)
    return bad_input("the map has no occupied node: it would mean that there is no obstacle at all", name,
                     kRemakeMap);
  return header;
}

}  // namespace omniflight::planning
