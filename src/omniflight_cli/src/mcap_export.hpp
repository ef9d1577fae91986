// A Recording of whatever origin as MCAP with our topics, so that it replays and opens in ROS 2 tools.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::cli {

struct McapExport {
  std::map<std::string, std::uint64_t> messages;  ///< by topic
  std::map<std::string, std::string> types;       ///< by topic
  std::vector<std::string> left_out;       ///< signals that no topic carries, topics that cannot be copied
  std::int64_t first_ns = 0, last_ns = 0;  ///< stamps
};

/// Writes the file whole or not at all. Of an MCAP recording every topic and message is copied as it is:
/// schemas, frames, stamps, sequence, metadata, attachments and counts of dropped messages; topics that are
/// not CDR with ros2msg are left out. Of any other recording: one message a sample of a topic's first signal;
/// its other signals are interpolated to that time, which is exact where they were logged together. Fields
/// that were not recorded are NaN.
Result<McapExport> write_mcap(const recording::Recording& recording, const std::filesystem::path& path);
/// A rosbag2 folder: NAME_0.mcap and metadata.yaml. The folder must not exist.
Result<McapExport> write_rosbag2(const recording::Recording& recording, const std::filesystem::path& folder);

}  // namespace omniflight::cli
