// What is left to do when all messages were seen: clocks, the choice among topics, and what is told.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "omniflight_files/files.hpp"
#include "topic_feeds.hpp"

namespace omniflight::recording {
namespace {

constexpr std::int64_t kOtherClock = 10'000'000'000;  // stamps of one clock differ less from their log times

std::string counted(std::uint64_t n, const char* what) { return std::to_string(n) + " " + what; }

}  // namespace

/// Topics whose stamps are of another clock than those of the busiest one are moved by what the log times
/// say.
void TopicFeeds::align_clocks() {
  const Topic* main = nullptr;
  for (const Topic& t : topics_)
    if (t.decoder && t.clock_ns && (!main || t.messages > main->messages)) main = &t;
  if (!main) return;
  const auto behind_s = [&](const Topic& t) {
    const double ns = static_cast<double>(main->least_delay_ns) - static_cast<double>(t.least_delay_ns);
    return std::abs(ns) > kOtherClock ? 1e-9 * ns : 0.0;
  };
  const double base_s = base_topic_ ? behind_s(topics_[*base_topic_]) : 0.0;
  for (const Topic& t : topics_) {
    if (!t.decoder) continue;
    const double by_s = behind_s(t);
    if (by_s != base_s)
      for (const Feed& f : t.feeds) collector_.shift(f.key, by_s - base_s);
    if (by_s != 0)
      recording_.note(Note::Kind::information, t.shown + ": its stamps are of another clock than those of " +
                                                   main->shown + "; moved by " + std::to_string(by_s) +
                                                   " s as their log times say");
  }
  start_at(base_ns_ + static_cast<std::int64_t>(base_s * 1e9));
}

/// Of several topics that give one signal the preferred one stays.
void TopicFeeds::choose() {
  std::map<std::string, std::set<std::string>> keys;  // signal -> keys by preference
  for (const Topic& t : topics_)
    for (const Feed& f : t.feeds) {
      if (collector_.count(f.key) > 0) keys[f.signal->signal].insert(f.key);
    }
  for (const Topic& t : topics_)  // what was refused of a signal that nothing else gives is told, too
    for (const Feed& f : t.feeds)
      if (collector_.refused(f.key) > 0 && !keys.contains(f.signal->signal))
        keys[f.signal->signal].insert(f.key);
  const auto topic_in = [](const std::string& key) {
    const auto from = key.find('\n') + 1;
    return key.substr(from, key.find('\n', from) - from);
  };
  for (const auto& [signal, candidates] : keys) {
    const std::string& best = *candidates.begin();
    std::set<std::string> equals;  // other topics that the same line of a map fits
    for (const std::string& other : candidates)
      if (other.substr(0, 6) == best.substr(0, 6) && topic_in(other) != topic_in(best))
        equals.insert(topic_in(other));
    std::string also;
    for (const auto& name : equals) also += (also.empty() ? "" : ", ") + name;
    if (!also.empty())
      recording_.note(Note::Kind::information, signal + ": " + topic_in(best) + " was taken; " + also +
                                                   " would give it, too (a map can choose)");
  }
  for (Topic& t : topics_)
    for (Feed& f : t.feeds) {
      const auto found = keys.find(f.signal->signal);
      f.chosen = found != keys.end() && *found->second.begin() == f.key;
      if (f.chosen)
        collector_.rename(f.key, f.signal->signal);
      else
        collector_.forget(f.key);
    }
}

void TopicFeeds::summarise() {
  for (const Topic& t : topics_) {
    TopicSummary summary{t.shown, t.type, t.messages, {}};
    for (const Feed& f : t.feeds)
      if (f.chosen && recording_.find(f.signal->signal)) summary.feeds.push_back(f.signal->signal);
    if (t.by_type && !summary.feeds.empty())
      recording_.note(Note::Kind::information,
                      "topic " + files::shown(t.shown) + " was taken for what it is by its type, " + t.type);
    if (t.undecodable > 0)
      recording_.note(Note::Kind::damage,
                      t.shown + ": " + counted(t.undecodable, "messages do not fit their definition"),
                      t.undecodable);
    if (t.misdated > 0)
      recording_.note(Note::Kind::damage,
                      t.shown + ": " +
                          counted(t.misdated,
                                  "stamps are more than 60 s off; the time when those "
                                  "messages were logged was taken"),
                      t.misdated);
    for (const Feed& f : t.feeds)
      if (f.outside > 0)
        recording_.note(Note::Kind::ignored,
                        t.shown + ": " + counted(f.outside, "messages were left out whose ") +
                            f.signal->signal + " is not valid by their own flags, or out of range",
                        f.outside);
    recording_.topics.push_back(std::move(summary));
  }
  std::sort(recording_.topics.begin(), recording_.topics.end(),
            [](const TopicSummary& a, const TopicSummary& b) { return a.name < b.name; });
}

Status TopicFeeds::finish() {
  if (!status_) return status_;
  if (topics_.size() >= kMaxTopics)
    recording_.note(Note::Kind::loss, "the log has more than 65536 topics; the rest was left out");
  if (feeding_ > kMaxFeeding)
    recording_.note(Note::Kind::loss, "more than 500 topics would give signals; the rest was left out");
  align_clocks();
  choose();
  recording_.start_s = 1e-9 * static_cast<double>(base_ns_);
  collector_.finish(recording_);
  summarise();
  return {};
}

}  // namespace omniflight::recording
