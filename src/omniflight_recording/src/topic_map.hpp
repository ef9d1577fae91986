// Which topics of a bag are which signals.
#pragma once

#include <string>
#include <vector>

namespace omniflight::recording {

struct TopicSignal {
  const char* signal;
  std::vector<const char*> fields;  // several scalars, or one array whose numbers are the components
};
struct TopicEntry {
  const char* topic;  // without a leading "rt"
  const char* type;   // "pkg/Name"
  std::vector<TopicSignal> signals;
};
/// In order of preference: when two topics give the same signal, the first one is used.
const std::vector<TopicEntry>& topic_map();

}  // namespace omniflight::recording
