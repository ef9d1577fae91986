// Turns the messages of a log's topics into the signals of a recording, as a topic map says.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collector.hpp"
#include "message_decoder.hpp"
#include "topic_map.hpp"

namespace omniflight::recording {

/// A topic as a log declares it.
struct DeclaredTopic {
  std::string name, type;      // type as "pkg/Name"; empty where the format has none
  std::uint32_t instance = 0;  // of topics that exist several times under one name
  Encoding encoding = Encoding::xcdr1;
  std::string definition;               // ROS .msg text; empty: that of the map
  const MessageTypes* types = nullptr;  // instead of a definition
  std::string unreadable;               // why its messages cannot be decoded; empty: they can
};

/// Where several topics give one signal, the one is used that the map prefers among those with a sample.
class TopicFeeds {
 public:
  TopicFeeds(TopicMap map, Recording& recording) : map_(std::move(map)), recording_(recording) {}

  /// Declares a topic; the answer stands for it in `message`. Several publishers may share a topic.
  std::size_t open(const DeclaredTopic& topic);

  /// One message; log_ns is when it was logged [ns]. Messages that are not of the declared type are counted.
  void message(std::size_t topic, std::string_view data, std::int64_t log_ns);

  /// Signals with one component a rotor have no more than these.
  void limit_rotors(std::size_t count) { rotors_ = std::min(count, kMaxRotors); }

  /// Second 0 of the recording [ns]. Without it: 0, or the first stamp where the clock is an epoch.
  void start_at(std::int64_t ns);
  std::int64_t base_ns() const { return base_ns_; }

  /// Fills signals, topics and notes of the recording. An error when a shipped map is faulty.
  Status finish();

 private:
  /// One signal of one topic.
  struct Feed {
    const TopicSignal* signal = nullptr;
    std::string key;  // in the collector: preference, topic, signal
    int width = 0;    // of the canonical signal; 0: one a rotor
    std::vector<std::size_t> slots, turned_by, where;
    std::optional<std::size_t> count;
    std::uint64_t outside = 0;  // messages whose numbers or conditions make them no measurement
    bool chosen = false;        // no preferred topic gives the signal
  };
  struct Topic {
    std::string name, type, shown;
    std::optional<MessageDecoder> decoder;
    std::vector<std::string> wanted;
    std::vector<std::size_t> time;  // slots: sec and nanosec, or one number
    bool stamped = false;
    std::int64_t time_ns = 0;  // 0: sec and nanosec
    std::vector<Feed> feeds;
    std::uint64_t messages = 0, undecodable = 0, misdated = 0;
    std::optional<std::int64_t> clock_ns;  // its stamps minus log times, at the first message
    std::int64_t least_delay_ns = 0;       // the same where that is largest: what its clock differs by
    bool by_type = false;                  // taken for what it is by its type alone
  };

  void look_up();
  const MessageTypes& definitions();
  bool prepare(Topic& topic, const DeclaredTopic& declared);
  void drop_incomplete(Topic& topic, const MessageDecoder& decoder, bool told);
  void add_feeds(Topic& topic, std::size_t entry, std::uint32_t instance);
  std::int64_t stamp_of(Topic& topic, std::int64_t log_ns);
  void add_sample(Feed& feed, double t_s);
  bool convert(const Feed& feed);
  void align_clocks();
  void choose();
  void summarise();

  TopicMap map_;
  Status status_;
  Recording& recording_;
  Collector collector_;
  std::vector<Topic> topics_;
  std::map<std::pair<std::string, std::string>, std::size_t> index_;  // of topics_, by name and type
  std::vector<std::vector<double>> numbers_;
  std::vector<double> row_;
  static constexpr std::size_t kMaxRotors = 64, kMaxTopics = 65536, kMaxFeeding = 500;
  std::size_t rotors_ = kMaxRotors;
  std::size_t feeding_ = 0;  // topics that an entry of the map fits
  std::int64_t base_ns_ = 0;
  std::optional<std::size_t> base_topic_;  // whose first stamp is second 0
  bool have_base_ = false;
};

}  // namespace omniflight::recording
