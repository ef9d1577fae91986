// Whitened columns of laws that bend, remembered: a search asks for the same bends again and again.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "omniflight_physics/effect.hpp"

namespace omniflight::diagnosis {

/// May be shared between threads. Keeps what came first until it is full.
class ColumnMemory {
 public:
  using Columns = std::shared_ptr<const Eigen::MatrixXd>;

  /// What make() returned for this effect at these parameter values, now or before.
  template <class Make>
  Columns at(const physics::Effect& effect, const std::vector<double>& theta, const Make& make) {
    const Key key{&effect, theta};
    {
      const std::lock_guard lock(mutex_);
      if (const auto known = known_.find(key); known != known_.end()) return known->second;
    }
    auto columns = std::make_shared<const Eigen::MatrixXd>(make());
    const std::lock_guard lock(mutex_);
    const auto bytes = sizeof(double) * static_cast<std::size_t>(columns->size());
    if (used_ + bytes <= kMostBytes && known_.emplace(key, columns).second) used_ += bytes;
    return columns;
  }

 private:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 30;
  using Key = std::pair<const physics::Effect*, std::vector<double>>;
  std::mutex mutex_;
  std::map<Key, Columns> known_;
  std::size_t used_ = 0;
};

}  // namespace omniflight::diagnosis
