// Formats that are known and not read: what to convert them with.
#pragma once

#include <string_view>

namespace omniflight::recording {

struct OtherFormat {
  const char* name;
  const char* conversion;  // a sentence with the command
};

/// The format by its first bytes; nullptr when it is none of these.
const OtherFormat* find_other_format(std::string_view head);

}  // namespace omniflight::recording
