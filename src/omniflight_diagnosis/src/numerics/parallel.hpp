// Independent pieces of work spread over threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace omniflight::diagnosis {

/// work(i, worker) for every i < count, on up to `threads` threads, of which the calling one is worker 0.
/// When `stop`, asked by the calling thread, says so, what is not begun is left out.
inline void parallel_for_workers(std::size_t count, int threads,
                                 const std::function<void(std::size_t, std::size_t)>& work,
                                 const std::function<bool()>& stop = {}) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> ended{false};
  const auto run = [&](std::size_t worker) {
    while (!ended) {
      const std::size_t i = next++;
      if (i >= count) return;
      if (worker == 0 && stop && stop())
        ended = true;
      else
        work(i, worker);
    }
  };
  std::vector<std::jthread> others;
  for (int k = 1; k < threads && static_cast<std::size_t>(k) < count; ++k)
    others.emplace_back([&run, k] { run(static_cast<std::size_t>(k)); });
  run(0);
}

/// The same where it does not matter who works.
inline void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& work,
                         const std::function<bool()>& stop = {}) {
  parallel_for_workers(
      count, threads, [&](std::size_t i, std::size_t) { work(i); }, stop);
}

}  // namespace omniflight::diagnosis
