#include "blocks.hpp"

#include <algorithm>

#include "omniflight_core/random.hpp"

namespace omniflight::diagnosis {

std::vector<int> blocks_of(const Problem& problem, int& count) {
  std::vector<int> block(static_cast<std::size_t>(problem.samples()), 0);
  const int length = std::max(40, problem.samples() / (20 * std::max(1, problem.flights())));
  count = 0;
  for (const Run& run : problem.runs()) {
    const int parts = std::max(1, (run.end - run.begin + length / 2) / length);
    for (int i = run.begin; i < run.end; ++i)
      block[static_cast<std::size_t>(i)] =
          count + static_cast<int>(static_cast<long>(i - run.begin) * parts / (run.end - run.begin));
    count += parts;
  }
  return block;
}

std::vector<int> random_folds(const Problem& problem, int& count) {
  std::vector<int> fold = blocks_of(problem, count);
  Random random(1, "folds");
  for (std::size_t n = fold.size(); n > 1; --n) std::swap(fold[n - 1], fold[random.next() % n]);
  return fold;
}

}  // namespace omniflight::diagnosis
