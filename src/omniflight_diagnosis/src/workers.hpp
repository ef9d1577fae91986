// Independent pieces of work on one problem, spread over the processors.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "problem.hpp"

namespace omniflight::diagnosis {

/// A Problem remembers what it computed and must not be shared: every thread but the calling one has its own.
class Workers {
 public:
  Workers(const Problem& problem, int threads)
      : problem_(problem), copies_(static_cast<std::size_t>(threads > 1 ? threads - 1 : 0), problem) {}

  /// work(problem, i) for every i below count, whose result may depend on i only; in the order of i. When
  /// stop, asked by the calling thread, says so, what is not begun is left out, and the results end there.
  template <class T>
  std::vector<T> map(std::size_t count, const std::function<T(const Problem&, std::size_t)>& work,
                     const std::function<bool()>& stop = {}) const {
    std::vector<std::optional<T>> done(count);
    std::atomic<std::size_t> next{0};
    std::atomic<bool> ended{false};
    const auto run = [&](const Problem& problem, bool calling) {
      while (!ended) {
        const std::size_t i = next++;
        if (i >= count) return;
        if (calling && stop && stop())
          ended = true;
        else
          done[i] = work(problem, i);
      }
    };
    {
      std::vector<std::jthread> others;
      for (std::size_t k = 0; k < copies_.size() && k + 1 < count; ++k)
        others.emplace_back([&run, &own = copies_[k]] { run(own, false); });
      run(problem_, true);
    }
    std::vector<T> out;
    for (std::optional<T>& one : done) {
      if (!one) break;
      out.push_back(std::move(*one));
    }
    return out;
  }

 private:
  const Problem& problem_;
  std::vector<Problem> copies_;
};

}  // namespace omniflight::diagnosis
