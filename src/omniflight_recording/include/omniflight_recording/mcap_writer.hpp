// MCAP files as ROS 2 tools read them (profile "ros2"), written so that a killed process loses at most the
// last flush period: one write(2) per chunk, nothing buffered in the process behind it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "omniflight_core/result.hpp"

namespace omniflight::recording {

struct McapWriterOptions {
  std::size_t chunk_bytes = 256 * 1024;        ///< a chunk is written when it holds this much
  std::uint64_t chunk_period_ns = 40'000'000;  ///< or when its first message is this old [ns]; a kill loses
                                               ///< that and what passes until tick() is called
  int zstd_level = 1;                          ///< higher is smaller and slower
  bool sync = false;  ///< fdatasync after each chunk: survives power loss too, may block for milliseconds
  bool overwrite = false;  ///< replace an existing file (otherwise an error)
};

/// One topic. `schema_text` is the ros2msg definition with its dependencies ("====" and "MSG:" separators).
struct McapTopic {
  std::string topic;  ///< ROS name, for instance /omniflight/imu
  std::string type;   ///< for instance sensor_msgs/msg/Imu
  std::string schema_text;
  std::string offered_qos_profiles;  ///< YAML, as rosbag2 stores it
  std::string type_hash;             ///< RIHS01_..., may be empty
};

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint64_t dropped = 0;
  std::uint64_t bytes = 0;  ///< written to the file so far
  std::uint32_t chunks = 0;
};

/// Not thread safe; use it from the recorder's writing thread. After an error (a full disk) the file is cut
/// back to its last whole record, every further call returns the same error, and what was written stays
/// readable.
class McapWriter {
 public:
  /// Creates the file and writes its header at once.
  static Result<std::unique_ptr<McapWriter>> create(const std::filesystem::path& path,
                                                    const McapWriterOptions& options = {});
  ~McapWriter();  ///< closes, ignoring errors; call close() to see them
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Registers a topic and writes its schema and channel at once. Returns the channel id.
  Result<std::uint16_t> add_topic(const McapTopic& topic);
  /// Appends a message: CDR with its 4-byte encapsulation header. now_ns is any monotonic clock, used only
  /// for the age of the chunk; log and publish times are what the file says [ns since the epoch or simulation
  /// start].
  Status write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_ns, std::uint64_t publish_ns,
               std::string_view cdr, std::uint64_t now_ns);
  /// Writes the open chunk when it is old enough; call it at least every few tens of milliseconds.
  Status tick(std::uint64_t now_ns);
  /// Writes the open chunk now.
  Status flush();
  /// Counts messages of a topic that never reached write() (queue overflow, middleware loss).
  void count_dropped(std::uint16_t channel, std::uint64_t count = 1);
  /// Writes the drop counters of all topics as metadata record "omniflight.dropped" (totals so far).
  Status write_dropped();
  Status write_metadata(const std::string& name, const std::map<std::string, std::string>& values);
  Status write_attachment(const std::string& name, const std::string& media_type, std::uint64_t log_ns,
                          std::string_view data);
  /// Chunk, drop counters, summary with indexes and statistics, footer. Idempotent.
  Status close();
  McapStatistics statistics() const;

 private:
  struct State;
  explicit McapWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace omniflight::recording
