// Independent pieces of work spread over threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace omniflight::diagnosis {

/// work(i) for every i < count, on up to `threads` threads; what is not begun when `stop` says so is left
/// out.
inline void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& work,
                         const std::function<bool()>& stop = {}) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> ended{false};
  const auto run = [&](bool calling) {
    while (!ended) {
      const std::size_t i = next++;
      if (i >= count) return;
      if (calling && stop && stop())
        ended = true;
      else
        work(i);
    }
  };
  std::vector<std::jthread> others;
  for (int k = 1; k < threads && static_cast<std::size_t>(k) < count; ++k)
    others.emplace_back([&run] { run(false); });
  run(true);
}

}  // namespace omniflight::diagnosis
