// RRTConnect with several seeds side by side on the cores at hand.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "connect_search.hpp"
#include "omniflight_planning/planner.hpp"

namespace omniflight::planning {

/// As many searches as options.threads, each with a seed of its own. The answer does not depend on which
/// thread is quicker: time is counted in samples. All searches take the same number of them, block by block;
/// the first block in which one of them finds a path decides, and in it the search with the lowest number. So
/// a seed and a number of threads give the same path whenever the budget suffices. One thread is one search
/// in this thread.
class Portfolio {
 public:
  Portfolio(const StateCheck& check, const Pose& start, const Pose& goal, const PathOptions& options);

  /// Continues every search for so many samples at most, or to the deadline.
  std::optional<std::vector<Pose>> solve(const Deadline& end, std::size_t samples);

  /// Does `work` in this thread while the other ones search ahead, to the deadline or until it is done. What
  /// they find counts in its turn, when solve() comes to the block in which they found it.
  void meanwhile(const Deadline& end, const std::function<void()>& work);

 private:
  struct Search {
    Search(const StateCheck& check, const Pose& start, const Pose& goal, std::uint64_t seed)
        : rrt(check, start, goal, seed) {}
    ConnectSearch rrt;
    std::size_t done = 0;  // samples
    std::optional<std::vector<Pose>> path;
    void go_on(const Deadline& end, std::size_t samples);
  };
  std::vector<std::unique_ptr<Search>> searches_;
  std::size_t done_ = 0;  // samples of each that have been looked at
};

}  // namespace omniflight::planning
