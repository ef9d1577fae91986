// Real recordings live outside the project; tests that need them are skipped with the reason where they are
// absent.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

inline std::filesystem::path real_data(const std::string& relative) {
  const char* chosen = std::getenv("OMNIFLIGHT_REAL_DATA");
  std::filesystem::path root = chosen && *chosen
                                   ? std::filesystem::path(chosen)
                                   : std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT) / "../shared/data";
  return root / relative;
}

#define NEEDS_REAL_DATA(relative)                    \
  if (!std::filesystem::exists(real_data(relative))) \
  GTEST_SKIP() << "real recording " << real_data(relative) << " is absent (OMNIFLIGHT_REAL_DATA)"
