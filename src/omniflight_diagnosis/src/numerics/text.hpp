// Sentences with numbers in them.
#pragma once

#include <cstdio>
#include <string>

namespace omniflight::diagnosis {

/// As printf; what is longer than 400 characters is cut.
std::string format(const char* pattern, auto... values) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

}  // namespace omniflight::diagnosis
