// Real recordings, where the machine has some.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace omniflight::diagnosis::test {

inline std::filesystem::path flights() {
  const char* given = std::getenv("OMNIFLIGHT_REAL_DATA");
  return (given ? std::filesystem::path(given)
                : std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT "/../shared/data")) /
         "flights";
}

}  // namespace omniflight::diagnosis::test
