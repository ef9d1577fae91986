// Reads the records of a PX4 ULog in memory, in the order of the file, whatever state the file is in.
// Format: docs.px4.io, "ULog File Format".
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "message_definition.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

struct UlogSubscription {
  std::uint16_t id = 0;
  std::string name;
  std::uint8_t instance = 0;
};
struct UlogText {
  std::uint64_t at_us = 0;
  char level = '7';  // '0' (emergency) to '7' (debug), as in syslog
  std::string text;
};
struct UlogChange {
  std::uint64_t at_us = 0;  // of the last message before
  std::string name;
  double value = 0;
};
struct UlogDropout {
  std::uint64_t at_us = 0;  // of the last message before
  std::uint32_t duration_ms = 0;
};

/// What was found besides the messages.
struct UlogContent {
  unsigned version = 0;
  std::uint64_t start_us = 0;  // of the header
  MessageTypes types;
  std::map<std::string, std::string> information;
  std::map<std::string, double> parameters;  // when the log begins
  std::vector<UlogChange> changes;           // of parameters, in flight
  std::vector<UlogText> texts;
  std::vector<UlogDropout> dropouts;
  std::uint64_t messages = 0, dropouts_ms = 0, dropout_count = 0, text_count = 0;
  std::vector<Note> notes;  // every loss or damage
};

/// The content so far (formats come before their messages), the subscription, the bytes of the message and
/// when it was logged [us]: its time stamp, or that of the message before where its own is far from all
/// others.
using UlogVisitor =
    std::function<void(const UlogContent&, const UlogSubscription&, std::string_view, std::uint64_t)>;

/// Scans all records, appended sections included. Behind damage the scan goes on where four records follow
/// each other; a cut file is read to its last whole record. An error only when there is no ULog header, or
/// the file says that it cannot be read without knowing more.
Result<UlogContent> scan_ulog(std::string_view bytes, const std::string& file, const UlogVisitor& visit);

}  // namespace omniflight::recording
