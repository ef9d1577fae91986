// Our recordings and ROS 2 bags in MCAP: every message of a known topic becomes samples of canonical signals.
#include <cstdlib>

#include "format_table.hpp"
#include "mcap_records.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_reader.hpp"
#include "topic_feeds.hpp"

namespace omniflight::recording {
namespace {

class McapLoader {
 public:
  McapLoader(TopicMap map, Recording& recording) : recording_(recording), feeds_(std::move(map), recording) {}

  void message(const McapChannel& channel, const McapMessage& m) {
    const auto [place, fresh] = channels_.try_emplace(channel.id);
    Channel& c = place->second;
    if (fresh) c.topic = open(channel);
    if (!fresh && m.sequence > c.last_sequence + 1) c.missing += m.sequence - c.last_sequence - 1;
    c.last_sequence = m.sequence;
    feeds_.message(c.topic, m.data, static_cast<std::int64_t>(m.log_ns));
  }

  Status finish(const McapContent& content) {
    for (const auto& [id, channel] : content.channels)
      if (!channels_.contains(id)) open(channel);  // nothing was said on it
    if (auto ok = feeds_.finish(); !ok) return ok;
    for (const auto& [id, c] : channels_)
      if (c.missing > 0 && content.library == "omniflight")
        recording_.note(Note::Kind::loss,
                        content.channels.at(id).topic + ": " + std::to_string(c.missing) +
                            " messages are missing in the sequence",
                        c.missing);
    for (const auto& [name, values] : content.metadata)
      for (const auto& [key, value] : values) {
        recording_.metadata[name + "." + key] = value;
        if (name == "omniflight.dropped" && value != "0")
          recording_.note(Note::Kind::loss,
                          key + ": the recorder dropped " + files::shown(value) + " messages",
                          std::strtoull(value.c_str(), nullptr, 10));
      }
    for (const auto& a : content.attachments) recording_.metadata["attachment." + a.name] = a.data;
    recording_.metadata["mcap.profile"] = content.profile;
    recording_.metadata["mcap.library"] = content.library;
    recording_.metadata["mcap.closed"] = content.closed ? "yes" : "no";
    const double base = 1e-9 * static_cast<double>(feeds_.base_ns());
    for (Note n : content.notes) {
      if (n.from_s != 0 || n.to_s != 0) n.from_s -= base, n.to_s -= base;
      recording_.notes.push_back(std::move(n));
    }
    return {};
  }

 private:
  struct Channel {
    std::size_t topic = 0;
    std::uint32_t last_sequence = 0;
    std::uint64_t missing = 0;
  };

  std::size_t open(const McapChannel& channel) {
    DeclaredTopic topic;
    topic.name = channel.topic;
    topic.type = short_type(channel.schema.name);
    const auto is = [&](const char* message, const char* schema) {
      return channel.message_encoding == message && channel.schema.encoding == schema;
    };
    if (is("ros1", "ros1msg"))  // a ROS 1 bag that was converted
      topic.encoding = Encoding::ros1;
    else if (!is("cdr", "ros2msg"))
      topic.unreadable = "its messages are " + files::shown(channel.message_encoding) +
                         " by a definition in " + files::shown(channel.schema.encoding) +
                         "; cdr by ros2msg and ros1 by ros1msg are read";
    topic.definition = channel.schema.text;
    return feeds_.open(topic);
  }

  Recording& recording_;
  TopicFeeds feeds_;
  std::map<std::uint16_t, Channel> channels_;
};

bool is_mcap(std::string_view head) { return head.substr(0, mcap::kMagic.size()) == mcap::kMagic; }

Result<Recording> read_mcap(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  auto map = topic_map_for(options.map);
  if (!map) return Failure(map.error());
  Recording recording;
  McapLoader loader(std::move(*map), recording);
  const auto content =
      scan_mcap(bytes, file, [&](const McapChannel& c, const McapMessage& m) { loader.message(c, m); });
  if (!content) return Failure(content.error());
  if (auto ok = loader.finish(*content); !ok) return Failure(ok.error());
  return recording;
}

}  // namespace

const Format& mcap_format() {
  static const Format format{"mcap", "MCAP (omniflight or ROS 2)", is_mcap, read_mcap};
  return format;
}

}  // namespace omniflight::recording
