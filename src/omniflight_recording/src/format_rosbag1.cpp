// ROS 1 bags: messages decoded by the definitions that the bag carries, topics read as the maps say.
#include "format_table.hpp"
#include "rosbag1_reader.hpp"
#include "topic_feeds.hpp"

namespace omniflight::recording {
namespace {

bool is_rosbag1(std::string_view head) { return head.substr(0, kBag1Magic.size()) == kBag1Magic; }

Result<Recording> read_rosbag1(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  auto map = topic_map_for(options.map);
  if (!map) return Failure(map.error());
  Recording recording;
  TopicFeeds feeds(std::move(*map), recording);
  std::map<std::uint32_t, std::size_t> topics;
  const auto open = [&](std::uint32_t id, const Bag1Connection& c) {
    const auto [place, fresh] = topics.try_emplace(id, 0);
    if (fresh) {
      DeclaredTopic topic;
      topic.name = c.topic;
      topic.type = c.type;
      topic.encoding = Encoding::ros1;
      topic.definition = c.definition;
      if (c.definition.empty()) topic.unreadable = "the bag does not carry the definition of its type";
      place->second = feeds.open(topic);
    }
    return place->second;
  };
  const auto content = scan_bag1(
      bytes, file, [&](std::uint32_t id, const Bag1Connection& c, std::string_view data, std::int64_t ns) {
        feeds.message(open(id, c), data, ns);
      });
  if (!content) return Failure(content.error());
  for (const auto& [id, connection] : content->connections) open(id, connection);  // without a message
  if (auto ok = feeds.finish(); !ok) return Failure(ok.error());
  recording.notes.insert(recording.notes.end(), content->notes.begin(), content->notes.end());
  recording.metadata["rosbag1.messages"] = std::to_string(content->messages);
  recording.metadata["rosbag1.closed"] = content->closed ? "yes" : "no";
  for (const auto& [compression, chunks] : content->compressions)
    recording.metadata["rosbag1.chunks." + compression.substr(0, 20)] = std::to_string(chunks);
  return recording;
}

}  // namespace

const Format& rosbag1_format() {
  static const Format format{"rosbag1", "ROS 1 bag", is_rosbag1, read_rosbag1};
  return format;
}

}  // namespace omniflight::recording
