// Reads the messages of a ROS 1 bag in memory, in the order of the file, whatever state the file is in.
// Format: wiki.ros.org/Bags/Format/2.0.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

inline constexpr std::string_view kBag1Magic{"#ROSBAG V2.0\n"};

struct Bag1Connection {
  std::string topic, type, definition;  // type as "pkg/Name"
};

/// What was found besides the messages.
struct Bag1Content {
  std::map<std::uint32_t, Bag1Connection> connections;
  std::uint64_t messages = 0, chunks = 0;
  std::map<std::string, std::uint64_t> compressions;  // of chunks
  bool closed = false;                                // the recorder wrote its index
  std::vector<Note> notes;                            // every loss or damage
};

/// Number of the connection, the connection, the bytes of the message and when it was recorded [ns].
using Bag1Visitor = std::function<void(std::uint32_t, const Bag1Connection&, std::string_view, std::int64_t)>;

/// Scans all records. A chunk that cannot be unpacked is left out and noted; behind damage the scan goes on
/// at the next chunk; a cut file is read to its last whole message. An error only when it is no bag.
Result<Bag1Content> scan_bag1(std::string_view bytes, const std::string& file, const Bag1Visitor& visit);

}  // namespace omniflight::recording
