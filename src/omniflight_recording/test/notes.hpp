// What a recording tells of itself, for tests to look at.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"

namespace omniflight::recording {

inline bool has_note(const Recording& r, const std::string& part) {
  return std::any_of(r.notes.begin(), r.notes.end(),
                     [&](const Note& n) { return n.text.find(part) != std::string::npos; });
}

inline std::vector<std::string> texts(const Recording& r) {
  std::vector<std::string> out;
  for (const Note& n : r.notes) out.push_back(n.text);
  return out;
}

inline Eigen::Index samples(const Recording& r, const char* name) {
  return r.find(name) ? r.find(name)->size() : 0;
}

}  // namespace omniflight::recording
