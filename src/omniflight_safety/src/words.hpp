#pragma once

#include <cstdio>
#include <string>

namespace omniflight::safety {

/// `format` takes up to two numbers.
inline std::string words(const char* format, double a, double b = 0) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace omniflight::safety
