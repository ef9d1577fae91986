#include "portfolio.hpp"

#include <algorithm>
#include <system_error>
#include <thread>

namespace omniflight::planning {
namespace {

constexpr std::size_t kSamplesATurn = 250;        // samples between two comparisons of the searches
constexpr std::uint64_t kSeedStep = 982'451'653;  // far from those of missions and restarts

/// Threads that are joined, whatever happens; work for which there is none is done at once.
class Crew {
 public:
  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew() {
    for (std::thread& thread : threads_) thread.join();
  }
  /// False where the system gives no thread.
  bool begin(std::function<void()> work) {
    try {
      threads_.emplace_back(std::move(work));
      return true;
    } catch (const std::system_error&) {
      return false;
    }
  }

 private:
  std::vector<std::thread> threads_;
};

}  // namespace

void Portfolio::Search::go_on(const Deadline& end, std::size_t samples) {
  if (path) return;
  path = rrt.solve(end, samples);
  done += samples;
}

Portfolio::Portfolio(const StateCheck& check, const Pose& start, const Pose& goal,
                     const PathOptions& options) {
  const int threads = std::clamp(options.threads, 1, kMostPlannerThreads);
  for (int i = 0; i < threads; ++i)
    searches_.push_back(std::make_unique<Search>(check, start, goal,
                                                 options.seed + static_cast<std::uint64_t>(i) * kSeedStep));
}

std::optional<std::vector<Pose>> Portfolio::solve(const Deadline& end, std::size_t samples) {
  if (searches_.size() == 1) return searches_.front()->rrt.solve(end, samples);
  for (std::size_t left = samples; left > 0 && !end.passed();) {
    const std::size_t block = std::min(left, kSamplesATurn);
    left -= block;
    done_ += block;
    {
      Crew crew;
      for (std::size_t i = 1; i < searches_.size(); ++i) {
        Search* search = searches_[i].get();
        const auto work = [search, &end, this] {
          if (search->done < done_) search->go_on(end, done_ - search->done);
        };
        if (!search->path && search->done < done_ && !crew.begin(work)) work();
      }
      Search& first = *searches_.front();
      if (first.done < done_) first.go_on(end, done_ - first.done);
    }
    for (const auto& search : searches_)
      if (search->path && search->done <= done_) return search->path;
  }
  return std::nullopt;
}

void Portfolio::meanwhile(const Deadline& end, const std::function<void()>& work) {
  std::atomic<bool> over = false;
  Crew crew;
  for (std::size_t i = 1; i < searches_.size(); ++i) {
    Search* search = searches_[i].get();
    // the same blocks as solve() would take, from where they stand
    if (!crew.begin([search, &end, &over] {
          while (!over && !search->path && !end.passed()) search->go_on(end, kSamplesATurn);
        }))
      break;
  }
  work();
  over = true;
}

}  // namespace omniflight::planning
