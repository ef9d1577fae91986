// Which topics of a log are which signals: our own topics, and maps in YAML (README, "Maps").
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "frame_conversion.hpp"
#include "message_definition.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::recording {

/// A condition on a field of the message; it holds where the type has no such field.
struct FieldCondition {
  std::string field;
  bool equals = true;  // otherwise: differs
  double value = 0;
};

struct TopicSignal {
  std::string signal;
  std::vector<std::string> fields;  // several scalars, or one array whose numbers are the components
  Axes axes = Axes::as_they_are;
  bool xyzw = false;                 // order of the four numbers of an attitude; otherwise w x y z
  double scale = 1.0, offset = 0.0;  // value = number * scale + offset
  std::vector<std::string>
      turned_by;            // fields w x y z: a vector in body axes is turned into the world by them
  std::string count;        // field with the number of components that are used
  bool unused_nan = false;  // components behind those that are used are NaN
  double least = -std::numeric_limits<double>::infinity();  // numbers outside are no measurement
  double most = std::numeric_limits<double>::infinity();
  std::vector<FieldCondition> where;
};

/// `TopicEntry::map` of the map that the user gave.
inline constexpr const char* kGivenMap = "the given map";

struct TopicEntry {
  std::string
      topic;  // whole name with a leading "/", otherwise its end ("vehicle_odometry"); empty: any topic
  std::string type;  // "pkg/Name"; empty: any
  std::vector<std::string>
      time;                     // fields of the time stamp: the first that the type has; empty: header.stamp
  std::int64_t time_ns = 1000;  // of one step of those fields
  std::vector<TopicSignal> signals;
  std::string map;  // name of the map it stands in; empty for our own topics
};

struct TopicMap {
  std::deque<TopicEntry> entries;  // in order of preference: the first that gives a signal is used
  MessageTypes definitions;        // for bags that carry none
  bool shipped = false;            // the maps of the configuration folder are among the entries
};

/// Our own topics.
const std::vector<TopicEntry>& own_topics();

/// Reads one map. The error names file, line and field.
Result<TopicMap> load_topic_map(const std::filesystem::path& file);

/// `given` (a file, or a name under configs/topic_maps; may be empty), then our own topics.
Result<TopicMap> topic_map_for(const std::filesystem::path& given);

/// Appends every map under configs/topic_maps, unless that was done: first what names a topic, then what only
/// names a type. Entries keep their place in memory. An error when there is no configuration folder, or a map
/// in it is faulty.
Status add_shipped_maps(TopicMap& map);

/// Whether the topic is in our own name space.
bool is_own_name(const std::string& topic);

/// Entries of the map for a topic, as indexes in order of preference: of the given map, else of those that
/// name the topic, else of those that name its type. Of several names the longest counts.
std::vector<std::size_t> entries_for(const TopicMap& map, const std::string& topic, const std::string& type);

}  // namespace omniflight::recording
