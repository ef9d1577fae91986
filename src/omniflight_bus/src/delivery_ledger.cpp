#include "omniflight_bus/delivery_ledger.hpp"

#include <algorithm>

#include "omniflight_bus/message.hpp"

namespace omniflight::bus {

void DeliveryLedger::note(const msgs::omniflight_msgs::ComponentState& state) {
  const auto topics = view(state.topics);
  const auto sent = view(state.sent);
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < std::min(topics.size(), sent.size()); ++i) {
    Count& count = counts_[{std::string(text(topics[i])), std::string(text(state.name))}];
    if (sent[i] < count.now) count.earlier += count.now;
    count.now = sent[i];
  }
}

std::uint64_t DeliveryLedger::sent(std::string_view topic) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t total = 0;
  for (auto it = counts_.lower_bound({std::string(topic), std::string()}); it != counts_.end(); ++it) {
    if (it->first.first != topic) break;
    total += it->second.earlier + it->second.now;
  }
  return total;
}

std::uint64_t DeliveryLedger::lost(std::string_view topic, std::uint64_t received) const {
  const std::uint64_t total = sent(topic);
  return total > received ? total - received : 0;
}

}  // namespace omniflight::bus
