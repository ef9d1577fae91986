#include "topic_map.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

struct OwnSignal {
  const char* signal;
  std::vector<std::string> fields;
};
struct OwnTopic {
  const char* topic;
  const char* type;
  std::vector<OwnSignal> signals;
};

const std::vector<OwnTopic>& own_table() {
  static const std::vector<OwnTopic> table{
      {"/omniflight/imu",
       "sensor_msgs/Imu",
       {{"gyro", {"angular_velocity.x", "angular_velocity.y", "angular_velocity.z"}},
        {"acc", {"linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"}}}},
      {"/omniflight/mocap",
       "geometry_msgs/PoseStamped",
       {{"position", {"pose.position.x", "pose.position.y", "pose.position.z"}},
        {"attitude",
         {"pose.orientation.w", "pose.orientation.x", "pose.orientation.y", "pose.orientation.z"}}}},
      {"/omniflight/rotors",
       "omniflight_msgs/RotorTelemetry",
       {{"rotor_speed", {"velocity"}}, {"alpha", {"alpha"}}}},
      {"/omniflight/command",
       "actuator_msgs/Actuators",
       {{"rotor_command", {"velocity"}}, {"alpha_command", {"position"}}}},
      {"/omniflight/controller",
       "omniflight_msgs/ControllerState",
       {{"ref_position", {"ref_position"}},
        {"ref_attitude", {"ref_attitude"}},
        {"ref_velocity", {"ref_velocity"}},
        {"ref_angular_velocity", {"ref_angular_velocity"}},
        {"ref_acceleration", {"ref_acceleration"}},
        {"ref_angular_acceleration", {"ref_angular_acceleration"}},
        {"est_position", {"est_position"}},
        {"est_attitude", {"est_attitude"}},
        {"est_velocity", {"est_velocity"}},
        {"est_angular_velocity", {"est_angular_velocity"}},
        {"integral", {"integral"}},
        {"qddr", {"desired_acceleration"}}}},
      {"/omniflight/allocator",
       "omniflight_msgs/AllocatorState",
       {{"thrust_command", {"thrust"}}, {"qdd", {"achieved_acceleration"}}, {"alpha_command", {"alpha"}}}},
      {"/omniflight/battery", "sensor_msgs/BatteryState", {{"vbat", {"voltage"}}, {"ibat", {"current"}}}},
      {"/omniflight/truth",
       "omniflight_msgs/TruthState",
       {{"truth_position", {"position"}},
        {"truth_attitude", {"attitude"}},
        {"truth_velocity", {"velocity"}},
        {"truth_angular_velocity", {"angular_velocity"}},
        {"truth_rotor_speed", {"rotor_velocity"}},
        {"truth_alpha", {"alpha"}},
        {"truth_power", {"mechanical_power"}},
        {"truth_wrench", {"external_wrench"}}}},
      {"/omniflight/tick", "omniflight_msgs/Tick", {{"phase", {"phase"}}}},
  };
  return table;
}

/// Whether the topic has this name, or ends with it behind a "/" where the name has no leading one. PX4 adds
/// the version of a message to the name of its topic: "vehicle_status_v1".
bool named(std::string_view topic, std::string_view name) {
  if (!name.empty() && name[0] == '/') return topic == name;
  if (const auto v = topic.rfind("_v");
      v != std::string_view::npos && v + 2 < topic.size() &&
      topic.find_first_not_of("0123456789", v + 2) == std::string_view::npos)
    topic = topic.substr(0, v);
  if (topic.size() < name.size() || topic.substr(topic.size() - name.size()) != name) return false;
  return topic.size() == name.size() || topic[topic.size() - name.size() - 1] == '/';
}

/// Maps under configs/topic_maps by name; an error without a configuration folder.
Result<std::vector<std::filesystem::path>> shipped_maps() {
  std::vector<std::filesystem::path> out;
  const auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  std::error_code ec;
  for (const auto& entry : std::filesystem::directory_iterator(*configs / "topic_maps", ec))
    if (entry.path().extension() == ".yaml") out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

/// A map of the configuration, read again only when its file was changed: a campaign opens many recordings.
Result<TopicMap> cached_map(const std::filesystem::path& file) {
  struct Cached {
    std::filesystem::file_time_type time;
    std::uintmax_t size = 0;
    TopicMap map;
  };
  static std::mutex mutex;
  static std::map<std::filesystem::path, Cached> cache;
  constexpr std::size_t kMost = 100;  // files
  std::error_code no_time, no_size;
  const auto time = std::filesystem::last_write_time(file, no_time);
  const auto size = std::filesystem::file_size(file, no_size);
  const std::lock_guard lock(mutex);
  if (const auto known = cache.find(file); known != cache.end() && !no_time && !no_size &&
                                           known->second.time == time && known->second.size == size)
    return known->second.map;
  auto map = load_topic_map(file);
  if (map && !no_time && !no_size && cache.size() < kMost) cache[file] = {time, size, *map};
  return map;
}

}  // namespace

const std::vector<TopicEntry>& own_topics() {
  static const std::vector<TopicEntry> entries = [] {
    std::vector<TopicEntry> out;
    for (const OwnTopic& own : own_table()) {
      TopicEntry& entry = out.emplace_back();
      entry.topic = own.topic;
      entry.type = own.type;
      for (const OwnSignal& signal : own.signals) {
        entry.signals.emplace_back();
        entry.signals.back().signal = signal.signal;
        entry.signals.back().fields = signal.fields;
      }
    }
    return out;
  }();
  return entries;
}

Result<TopicMap> topic_map_for(const std::filesystem::path& given) {
  TopicMap out;
  if (!given.empty()) {
    std::filesystem::path file = given;
    std::error_code ec;
    if (const auto shipped = shipped_maps();
        shipped && !given.has_parent_path() && !std::filesystem::exists(given, ec))
      for (const auto& known : *shipped)
        if (known.stem() == given) file = known;
    auto map = load_topic_map(file);
    if (!map) return map;
    out = std::move(*map);
    for (TopicEntry& entry : out.entries) entry.map = kGivenMap;
  }
  const auto& own = own_topics();
  out.entries.insert(out.entries.end(), own.begin(), own.end());
  return out;
}

Status add_shipped_maps(TopicMap& map) {
  if (map.shipped) return {};
  map.shipped = true;
  std::vector<TopicEntry> by_type;
  const auto files = shipped_maps();
  if (!files) return Failure(files.error());
  for (const auto& file : *files) {
    auto shipped = cached_map(file);
    if (!shipped) return Failure(shipped.error());
    for (TopicEntry& entry : shipped->entries) {
      if (entry.topic.empty())
        by_type.push_back(std::move(entry));
      else
        map.entries.push_back(std::move(entry));
    }
    map.definitions.merge(shipped->definitions);
  }
  map.entries.insert(map.entries.end(), by_type.begin(), by_type.end());
  return {};
}

bool is_own_name(const std::string& topic) { return topic.rfind("/omniflight/", 0) == 0; }

std::vector<std::size_t> entries_for(const TopicMap& map, const std::string& topic, const std::string& type) {
  std::vector<std::size_t> out;
  const auto gather = [&](bool given, bool by_name) {
    std::size_t longest = 0;
    for (std::size_t i = 0; i < map.entries.size(); ++i) {
      const TopicEntry& e = map.entries[i];
      if ((e.map == kGivenMap) != given || e.topic.empty() == by_name) continue;
      if (!e.type.empty() && e.type != type) continue;
      if (by_name && (!named(topic, e.topic) || e.topic.size() < longest)) continue;
      if (by_name && e.topic.size() > longest) {
        longest = e.topic.size();
        out.clear();
      }
      out.push_back(i);
    }
    return !out.empty();
  };
  const bool ours = is_own_name(topic);  // never taken by its type alone
  if (gather(true, true) || gather(true, false) || gather(false, true) || ours) return out;
  gather(false, false);
  return out;
}

}  // namespace omniflight::recording
