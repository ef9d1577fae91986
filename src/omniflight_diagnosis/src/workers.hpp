// Independent pieces of work on one problem, spread over the processors.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "parallel.hpp"
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
    parallel_for_workers(
        count, static_cast<int>(copies_.size()) + 1,
        [&](std::size_t i, std::size_t worker) {
          done[i] = work(worker == 0 ? problem_ : copies_[worker - 1], i);
        },
        stop);
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
