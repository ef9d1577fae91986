#include "join.hpp"

#include <algorithm>

namespace omniflight::recording {
namespace {

/// The samples of `part`, moved by by_s [s], behind those of `whole`; how many were left out.
std::size_t append_signal(Signal& whole, const Signal& part, double by_s) {
  if (part.width() != whole.width()) return static_cast<std::size_t>(part.size());
  std::size_t first = 0;
  while (first < part.t_s.size() && !whole.empty() && part.t_s[first] + by_s <= whole.t_s.back()) ++first;
  const auto left = static_cast<Eigen::Index>(part.t_s.size() - first), before = whole.size();
  whole.values.conservativeResize(before + left, whole.width());
  whole.values.bottomRows(left) = part.values.bottomRows(left);
  for (std::size_t i = first; i < part.t_s.size(); ++i) whole.t_s.push_back(part.t_s[i] + by_s);
  return first;
}

void count_topics(std::vector<TopicSummary>& whole, std::vector<TopicSummary>&& part) {
  for (TopicSummary& t : part) {
    const auto known = std::find_if(whole.begin(), whole.end(), [&](const TopicSummary& w) {
      return w.name == t.name && w.type == t.type;
    });
    if (known == whole.end()) {
      whole.push_back(std::move(t));
      continue;
    }
    known->messages += t.messages;
    for (std::string& signal : t.feeds)
      if (std::find(known->feeds.begin(), known->feeds.end(), signal) == known->feeds.end())
        known->feeds.push_back(std::move(signal));
  }
}

}  // namespace

void append_part(Recording& whole, Recording&& part, const std::string& name) {
  const double by_s = part.start_s - whole.start_s;
  for (auto& [signal, samples] : part.signals) {
    auto [place, fresh] = whole.signals.try_emplace(signal);
    if (fresh) {
      place->second = std::move(samples);
      for (double& t : place->second.t_s) t += by_s;
    } else if (const std::size_t lost = append_signal(place->second, samples, by_s); lost > 0) {
      whole.note(Note::Kind::ignored,
                 name + ": " + std::to_string(lost) + " samples of " + signal +
                     " overlap with the part before, or have another width, and were left out",
                 lost);
    }
  }
  count_topics(whole.topics, std::move(part.topics));
  const auto told = [&](const Note& n) {
    return std::any_of(whole.notes.begin(), whole.notes.end(),
                       [&](const Note& w) { return w.text == n.text; });
  };
  for (Note& n : part.notes) {
    if (n.kind == Note::Kind::information && told(n)) continue;
    n.text = name + ": " + n.text;
    if (n.from_s != 0 || n.to_s != 0) n.from_s += by_s, n.to_s += by_s;
    whole.notes.push_back(std::move(n));
  }
  double first = 0, last = 0;
  bool any = false;
  for (const auto& [signal, samples] : whole.signals) {
    if (samples.empty()) continue;
    first = any ? std::min(first, samples.t_s.front()) : samples.t_s.front();
    last = any ? std::max(last, samples.t_s.back()) : samples.t_s.back();
    any = true;
  }
  whole.duration_s = last - first;
}

}  // namespace omniflight::recording
