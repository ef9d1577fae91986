// Our recordings and ROS 2 bags in MCAP: every message of a known topic becomes samples of canonical signals.
#include <algorithm>
#include <cmath>
#include <memory>

#include "collector.hpp"
#include "format_table.hpp"
#include "mcap_records.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_reader.hpp"
#include "ros2msg.hpp"
#include "topic_map.hpp"

namespace omniflight::recording {
namespace {

std::string without_msg(std::string type) {
  if (const auto at = type.find("/msg/"); at != std::string::npos) type.erase(at, 4);
  return type;
}

/// A topic being read: decoder and the signals it feeds.
struct Feed {
  const TopicEntry* entry = nullptr;
  std::unique_ptr<CdrDecoder> decoder;
  std::vector<std::vector<std::size_t>> slots;  // per signal: indexes into the decoder's wanted fields
  std::vector<bool> used;                       // per signal: not given by a preferred topic
  bool stamped = false;
  std::uint64_t undecodable = 0, decoded = 0, missing = 0;
  std::uint32_t last_sequence = 0;
};

class Loader {
 public:
  Loader(Recording& recording, Collector& collector) : recording_(recording), collector_(collector) {}

  void message(const McapChannel& channel, const McapMessage& m) {
    Feed& feed = feed_of(channel);
    if (feed.decoded + feed.undecodable > 0 && m.sequence > feed.last_sequence + 1)
      feed.missing += m.sequence - feed.last_sequence - 1;
    feed.last_sequence = m.sequence;
    if (!feed.decoder) return;
    if (!feed.decoder->decode(m.data, numbers_)) {
      ++feed.undecodable;
      return;
    }
    ++feed.decoded;
    std::int64_t stamp = static_cast<std::int64_t>(m.log_ns);
    if (feed.stamped && !numbers_[0].empty() && !numbers_[1].empty())
      stamp = static_cast<std::int64_t>(numbers_[0][0]) * 1'000'000'000 +
              static_cast<std::int64_t>(numbers_[1][0]);
    if (!have_base_) {
      have_base_ = true;
      base_ns_ =
          std::abs(stamp) > 1'000'000'000'000'000 ? stamp : 0;  // an epoch time: subtract before rounding
      recording_.start_s = 1e-9 * static_cast<double>(base_ns_);
    }
    const double t = 1e-9 * static_cast<double>(stamp - base_ns_);
    for (std::size_t k = 0; k < feed.slots.size(); ++k) {
      if (!feed.used[k]) continue;
      row_.clear();
      for (const std::size_t slot : feed.slots[k])
        row_.insert(row_.end(), numbers_[slot].begin(), numbers_[slot].end());
      const SignalSpec* spec = find_spec(feed.entry->signals[k].signal);
      if (spec->width == 1 && row_.size() > 1) row_.resize(1);
      if (row_.empty()) continue;  // for instance no current sensor
      if (std::none_of(row_.begin(), row_.end(), [](double v) { return std::isfinite(v); }))
        continue;  // "not measured"
      collector_.add(feed.entry->signals[k].signal, t, row_.data(), row_.size());
    }
  }

  void finish(const McapContent& content) {
    for (const auto& [id, feed] : feeds_) {
      const McapChannel& channel = content.channels.at(id);
      if (feed.undecodable > 0)
        recording_.note(
            Note::Kind::damage,
            channel.topic + ": " + std::to_string(feed.undecodable) + " messages do not fit their definition",
            feed.undecodable);
      if (feed.missing > 0 && content.library == "omniflight")
        recording_.note(
            Note::Kind::loss,
            channel.topic + ": " + std::to_string(feed.missing) + " messages are missing in the sequence",
            feed.missing);
    }
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
    const double base = 1e-9 * static_cast<double>(base_ns_);
    for (Note n : content.notes) {
      if (n.from_s != 0 || n.to_s != 0) n.from_s -= base, n.to_s -= base;
      recording_.notes.push_back(std::move(n));
    }
  }

 private:
  Feed& feed_of(const McapChannel& channel) {
    const auto [place, fresh] = feeds_.try_emplace(channel.id);
    Feed& feed = place->second;
    if (!fresh) return feed;
    const std::string type = without_msg(channel.schema.name);
    for (const TopicEntry& entry : topic_map())
      if (channel.topic == entry.topic && type == entry.type) feed.entry = &entry;
    if (!feed.entry || channel.message_encoding != "cdr" || channel.schema.encoding != "ros2msg") {
      recording_.note(
          feed.entry ? Note::Kind::ignored : Note::Kind::information,
          "topic " + files::shown(channel.topic) + " (" + channel.schema.name + ") has no known signal");
      feed.entry = nullptr;
      return feed;
    }
    std::vector<std::string> wanted{"header.stamp.sec", "header.stamp.nanosec"};
    for (const TopicSignal& s : feed.entry->signals) {
      feed.slots.emplace_back();
      for (const char* field : s.fields) {
        feed.slots.back().push_back(wanted.size());
        wanted.emplace_back(field);
      }
    }
    auto decoder = CdrDecoder::create(channel.schema.name, channel.schema.text, wanted);
    if (!decoder) {
      recording_.note(Note::Kind::damage, channel.topic + ": " + decoder.error().text());
      return feed;
    }
    feed.decoder = std::make_unique<CdrDecoder>(std::move(*decoder));
    feed.stamped = feed.decoder->has(0) && feed.decoder->has(1);
    for (std::size_t k = 0; k < feed.entry->signals.size(); ++k) {
      const std::string name = feed.entry->signals[k].signal;
      auto& owner = owner_[name];  // a preferred topic that appears later in the file still wins
      const bool better = !owner || feed.entry < owner;
      if (better) owner = feed.entry;
      feed.used.push_back(better);
      if (better) {
        collector_.forget(name);
        collector_.describe(name, find_spec(name)->unit,
                            channel.topic + " " + feed.entry->signals[k].fields.front());
        for (auto& [id, other] : feeds_)
          for (std::size_t j = 0; &other != &feed && other.entry && j < other.used.size(); ++j)
            if (name == other.entry->signals[j].signal) other.used[j] = false;
      }
    }
    return feed;
  }

  Recording& recording_;
  Collector& collector_;
  std::map<std::uint16_t, Feed> feeds_;
  std::map<std::string, const TopicEntry*> owner_;
  std::vector<std::vector<double>> numbers_;
  std::vector<double> row_;
  std::int64_t base_ns_ = 0;
  bool have_base_ = false;
};

bool sniff(std::string_view head) { return head.substr(0, mcap::kMagic.size()) == mcap::kMagic; }

Result<Recording> read(std::string_view bytes, const std::string& file, const LoadOptions&) {
  Recording recording;
  Collector collector;
  Loader loader(recording, collector);
  const auto content =
      scan_mcap(bytes, file, [&](const McapChannel& c, const McapMessage& m) { loader.message(c, m); });
  if (!content) return Failure(content.error());
  loader.finish(*content);
  collector.finish(recording);
  return recording;
}

}  // namespace

const Format& mcap_format() {
  static const Format format{"mcap", "MCAP (omniflight or ROS 2)", sniff, read};
  return format;
}

}  // namespace omniflight::recording
