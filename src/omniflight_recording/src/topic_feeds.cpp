#include "topic_feeds.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kEpoch = 1'000'000 * kSecond;  // clocks beyond are an epoch; they are subtracted
constexpr double kWrongStamp = 60e9;                  // ns; stamps do not move against log times by more
constexpr std::int64_t kLastTime = 3'000'000'000 * kSecond;  // in 2065; sums of three such times fit 64 bits

/// A topic that by its name says what is wanted, not what is.
bool names_a_wish(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* word :
       {"setpoint", "set_point", "goal", "reference", "target", "desired", "command", "cmd"})
    if (name.find(word) != std::string::npos) return true;
  return false;
}

std::size_t slot_of(std::vector<std::string>& wanted, const std::string& field) {
  const auto found = std::find(wanted.begin(), wanted.end(), field);
  if (found != wanted.end()) return static_cast<std::size_t>(found - wanted.begin());
  wanted.push_back(field);
  return wanted.size() - 1;
}

std::string padded(std::size_t number) {
  const std::string digits = std::to_string(number);
  return std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits;
}

std::int64_t bounded(std::int64_t ns) { return std::clamp(ns, -kLastTime, kLastTime); }

/// A name from a file, fit to be printed.
std::string printable(std::string name) {
  if (name.size() > 200) name.resize(200);
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return name;
}

}  // namespace

void TopicFeeds::add_feeds(Topic& topic, std::size_t index, std::uint32_t instance) {
  const TopicEntry& entry = map_.entries[index];
  for (const TopicSignal& signal : entry.signals) {
    Feed feed;
    feed.signal = &signal;
    feed.width = find_spec(signal.signal)->width;
    // sorted by preference; it ends with the signal, by which the collector knows attitudes
    feed.key = padded(index) + '\n' + topic.name + '\n' + padded(instance) + '\n' + signal.signal;
    for (const auto& field : signal.fields) feed.slots.push_back(slot_of(topic.wanted, field));
    for (const auto& field : signal.turned_by) feed.turned_by.push_back(slot_of(topic.wanted, field));
    for (const auto& c : signal.where) feed.where.push_back(slot_of(topic.wanted, c.field));
    if (!signal.count.empty()) feed.count = slot_of(topic.wanted, signal.count);
    topic.feeds.push_back(std::move(feed));
  }
}

/// A faulty map is an error; without any configuration our own topics can be read all the same.
void TopicFeeds::look_up() {
  const auto ok = add_shipped_maps(map_);
  if (ok) return;
  if (files::config_dir()) status_ = ok;
  recording_.note(Note::Kind::ignored, "maps of topics were not found: " + ok.error().text());
}

const MessageTypes& TopicFeeds::definitions() {
  look_up();
  return map_.definitions;
}

/// Without the signals whose fields the type does not have. Types that vary with the version of their
/// software are not named in a map, and then this is ordinary.
void TopicFeeds::drop_incomplete(Topic& topic, const MessageDecoder& decoder, bool told) {
  std::erase_if(topic.feeds, [&](const Feed& f) {
    std::vector<std::size_t> needed = f.slots;
    needed.insert(needed.end(), f.turned_by.begin(), f.turned_by.end());
    const auto missing =
        std::find_if(needed.begin(), needed.end(), [&](auto slot) { return !decoder.has(slot); });
    if (missing == needed.end()) return false;
    if (told)
      recording_.note(Note::Kind::ignored, topic.shown + ": " + f.signal->signal +
                                               " was not read, because its type has no field " +
                                               files::shown(topic.wanted[*missing]));
    return true;
  });
}

bool TopicFeeds::prepare(Topic& topic, const DeclaredTopic& declared) {
  auto entries = entries_for(map_, declared.name, declared.type);
  if (entries.empty() && !map_.shipped && !is_own_name(declared.name)) {
    look_up();
    entries = entries_for(map_, declared.name, declared.type);
  }
  if (entries.empty()) return false;
  if (++feeding_ > kMaxFeeding) return true;
  topic.by_type = map_.entries[entries.front()].topic.empty();
  if (topic.by_type && map_.entries[entries.front()].map != kGivenMap && names_a_wish(declared.name)) {
    recording_.note(Note::Kind::ignored, "topic " + files::shown(declared.name) + " (" + declared.type +
                                             ") was not taken for a measurement because of its name; "
                                             "a map can say what it is");
    return true;
  }
  if (!declared.unreadable.empty()) {
    recording_.note(Note::Kind::ignored, "topic " + files::shown(declared.name) + " (" + declared.type +
                                             ") cannot be decoded: " + declared.unreadable);
    return true;
  }
  const TopicEntry& first = map_.entries[entries.front()];
  topic.wanted =
      first.time.empty() ? std::vector<std::string>{"header.stamp.sec", "header.stamp.nanosec"} : first.time;
  const std::size_t stamps = topic.wanted.size();
  for (const std::size_t index : entries) add_feeds(topic, index, declared.instance);
  Result<MessageTypes> parsed = MessageTypes{};
  if (!declared.types && !declared.definition.empty()) {
    parsed = parse_ros_definition(declared.type, declared.definition);
    if (!parsed) {
      recording_.note(Note::Kind::damage, declared.name + ": " + parsed.error().text());
      return true;
    }
  }
  const MessageTypes& types = declared.types                 ? *declared.types
                              : !declared.definition.empty() ? *parsed
                                                             : definitions();
  auto decoder = MessageDecoder::create(declared.types ? declared.name : declared.type, types, topic.wanted,
                                        declared.encoding);
  if (!decoder) {
    const bool in_the_log = declared.types || !declared.definition.empty();
    recording_.note(in_the_log ? Note::Kind::damage : Note::Kind::ignored,
                    declared.name + ": " + decoder.error().text() +
                        (in_the_log ? ""
                                    : ". The bag does not carry it: add it to the definitions of a map, or "
                                      "convert the bag with ros2 bag convert to mcap"));
    return true;
  }
  drop_incomplete(topic, *decoder, !first.type.empty() || first.map == kGivenMap);
  if (topic.feeds.empty()) return false;
  topic.time_ns = first.time.empty() ? 0 : first.time_ns;
  for (std::size_t i = 0; i < stamps; ++i)
    if (decoder->has(i)) topic.time.push_back(i);
  topic.stamped = first.time.empty() ? topic.time.size() == 2 : !topic.time.empty();
  topic.decoder = std::move(*decoder);
  for (const Feed& feed : topic.feeds) {
    const TopicSignal& s = *feed.signal;
    const std::string from = to_string(s.axes);
    collector_.describe(feed.key, find_spec(s.signal)->unit,
                        topic.shown + " " + s.fields.front() +
                            (from.empty() ? "" : ", converted from " + from) +
                            (s.turned_by.empty() ? "" : ", turned from body to world axes"));
  }
  return true;
}

std::size_t TopicFeeds::open(const DeclaredTopic& declared) {
  const std::string shown =
      declared.instance == 0 ? declared.name : declared.name + "#" + std::to_string(declared.instance);
  if (const auto known = index_.find({shown, declared.type}); known != index_.end()) return known->second;
  if (topics_.size() >= kMaxTopics) return kMaxTopics;
  index_[{shown, declared.type}] = topics_.size();
  Topic& topic = topics_.emplace_back();
  topic.name = printable(declared.name);
  topic.type = printable(declared.type);
  topic.shown = printable(shown);
  if (!prepare(topic, declared) && !declared.types)
    recording_.note(declared.unreadable.empty() ? Note::Kind::information : Note::Kind::ignored,
                    "topic " + files::shown(declared.name) + " (" + declared.type + ") has no known signal");
  return topics_.size() - 1;
}

std::int64_t TopicFeeds::stamp_of(Topic& topic, std::int64_t log_ns) {
  if (!topic.stamped) return log_ns;
  double ns = 0;  // only to see that it is in range
  std::int64_t stamp = 0;
  if (topic.time_ns == 0) {
    const auto &sec = numbers_[topic.time[0]], &nanosec = numbers_[topic.time[1]];
    if (sec.empty() || nanosec.empty()) return log_ns;
    ns = sec[0] * 1e9 + nanosec[0];
    if (std::abs(ns) < static_cast<double>(kLastTime))
      stamp = static_cast<std::int64_t>(sec[0]) * kSecond + static_cast<std::int64_t>(nanosec[0]);
  } else {
    // the moment of the sample, or where that was not filled in, of the message
    for (const std::size_t slot : topic.time) {
      const auto& number = numbers_[slot];
      if (number.empty() || !(number[0] > 0)) continue;
      ns = number[0] * static_cast<double>(topic.time_ns);
      if (ns < static_cast<double>(kLastTime))
        stamp = topic.time_ns == kSecond ? static_cast<std::int64_t>(ns)
                                         : static_cast<std::int64_t>(number[0]) * topic.time_ns;
      break;
    }
  }
  if (ns == 0) return bounded(log_ns + topic.clock_ns.value_or(0));  // never filled in
  if (!topic.clock_ns && stamp != 0) topic.clock_ns = topic.least_delay_ns = stamp - log_ns;
  const std::int64_t clock = topic.clock_ns.value_or(0);
  if (stamp == 0 ||
      std::abs(static_cast<double>(stamp - log_ns) - static_cast<double>(clock)) > kWrongStamp) {
    ++topic.misdated;
    return bounded(log_ns + clock);
  }
  topic.least_delay_ns = std::max(topic.least_delay_ns, stamp - log_ns);
  return stamp;
}

/// The row in our units and axes; false where it is no measurement.
bool TopicFeeds::convert(const Feed& feed) {
  const TopicSignal& s = *feed.signal;
  if (std::any_of(row_.begin(), row_.end(), [&](double v) { return v < s.least || v > s.most; }))
    return false;
  for (double& v : row_) v = v * s.scale + s.offset;
  if (row_.size() == 4 && geometry_of(s.signal) == Geometry::attitude) {
    if (s.xyzw) std::rotate(row_.begin(), row_.begin() + 3, row_.end());
    if (s.axes != Axes::as_they_are) {
      const Quat q = to_our_axes(Quat(row_[0], row_[1], row_[2], row_[3]), s.axes);
      row_ = {q.w(), q.x(), q.y(), q.z()};
    }
  } else if (row_.size() == 3 && (s.axes != Axes::as_they_are || !s.turned_by.empty())) {
    Vec3 v(row_[0], row_[1], row_[2]);
    if (s.turned_by.empty()) {
      v = to_our_axes(v, s.axes);
    } else {
      std::vector<double> q;
      for (const std::size_t slot : feed.turned_by)
        q.insert(q.end(), numbers_[slot].begin(), numbers_[slot].end());
      if (q.size() != 4) return false;
      const Quat q_WB(q[0], q[1], q[2], q[3]);
      if (!(q_WB.squaredNorm() > 0.25 && q_WB.squaredNorm() < 4.0)) return false;
      v = turned_into_world(v, q_WB, s.axes);
    }
    row_ = {v.x(), v.y(), v.z()};
  }
  return true;
}

void TopicFeeds::add_sample(Feed& feed, double t_s) {
  for (std::size_t k = 0; k < feed.where.size(); ++k) {
    const auto& number = numbers_[feed.where[k]];
    const FieldCondition& c = feed.signal->where[k];
    if (!number.empty() && (number[0] == c.value) != c.equals) {
      ++feed.outside;
      return;
    }
  }
  row_.clear();
  for (const std::size_t slot : feed.slots)
    row_.insert(row_.end(), numbers_[slot].begin(), numbers_[slot].end());
  if (feed.width == 1 && row_.size() > 1) row_.resize(1);
  if (feed.width == 0) {
    std::size_t most = rotors_;
    if (feed.count && !numbers_[*feed.count].empty() && numbers_[*feed.count][0] >= 0)
      most = std::min(most, static_cast<std::size_t>(numbers_[*feed.count][0]));
    if (row_.size() > most) row_.resize(most);
    if (feed.signal->unused_nan && rotors_ == kMaxRotors)
      while (!row_.empty() && std::isnan(row_.back())) row_.pop_back();
  }
  if (row_.empty()) return;  // for instance no current sensor
  if (std::none_of(row_.begin(), row_.end(), [](double v) { return std::isfinite(v); }))
    return;  // "not measured"
  if (!convert(feed)) {
    ++feed.outside;
    return;
  }
  collector_.add(feed.key, t_s, row_.data(), row_.size());
}

void TopicFeeds::start_at(std::int64_t ns) {
  base_ns_ = bounded(ns);
  have_base_ = true;
}

void TopicFeeds::message(std::size_t index, std::string_view data, std::int64_t log_ns) {
  if (index >= topics_.size()) return;
  Topic& topic = topics_[index];
  ++topic.messages;
  if (!topic.decoder) return;
  if (!topic.decoder->decode(data, numbers_)) {
    ++topic.undecodable;
    return;
  }
  const std::int64_t stamp = stamp_of(topic, bounded(log_ns));
  if (!have_base_) {
    have_base_ = true;
    base_topic_ = index;
    base_ns_ = std::abs(stamp) > kEpoch ? stamp : 0;  // subtracted before rounding
  }
  const double t = 1e-9 * static_cast<double>(stamp - base_ns_);
  for (Feed& feed : topic.feeds) add_sample(feed, t);
}

}  // namespace omniflight::recording
