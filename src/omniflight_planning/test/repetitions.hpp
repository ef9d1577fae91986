// How often a test that draws its cases draws them: few times in every run, many times in the long tests.
#pragma once

#include <algorithm>
#include <cstdlib>

namespace omniflight::planning {

/// 1, or what OMNIFLIGHT_TIMES says (planning.drawn_more_often in CMakeLists.txt).
inline int times() {
  const char* told = std::getenv("OMNIFLIGHT_TIMES");
  return told ? std::max(1, std::atoi(told)) : 1;
}

}  // namespace omniflight::planning
