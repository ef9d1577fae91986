// Reads the messages of an MCAP file in memory, in the order of the file, whatever state the file is in.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

struct McapSchema {
  std::string name, encoding, text;
};
struct McapChannel {
  std::uint16_t id = 0;
  std::string topic, message_encoding;
  McapSchema schema;
  std::map<std::string, std::string> metadata;
  std::uint64_t messages = 0;  ///< read so far
};
struct McapMessage {
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0, publish_ns = 0;
  std::string_view data;  ///< valid during the callback only
};
struct McapAttachment {
  std::string name, media_type;
  std::uint64_t log_ns = 0;
  std::string data;
};

/// What was found besides the messages.
struct McapContent {
  std::string profile, library;
  std::map<std::uint16_t, McapChannel> channels;
  std::map<std::string, std::map<std::string, std::string>> metadata;  ///< the last record of each name
  std::vector<McapAttachment> attachments;
  std::uint64_t messages = 0;
  bool closed = false;      ///< footer present
  bool complete = false;    ///< footer present, all checksums and counts right
  std::vector<Note> notes;  ///< every loss or damage; times are absolute [s]
};

using McapVisitor = std::function<void(const McapChannel&, const McapMessage&)>;

/// Scans all records. Chunks whose CRC does not match are skipped and noted; behind damage the scan goes on
/// at the next sound chunk; a file without footer is read to its last whole record. An error only when
/// nothing of an MCAP file is there.
Result<McapContent> scan_mcap(std::string_view bytes, const std::string& file, const McapVisitor& visit);

}  // namespace omniflight::recording
