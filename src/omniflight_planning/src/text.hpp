// Messages with numbers in them.
#pragma once

#include <cstdio>
#include <string>

namespace omniflight::planning {

/// printf into a string of at most 799 characters.
std::string text(const char* format, auto... values) {
  char buffer[800];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

}  // namespace omniflight::planning
