// A diagnosis that ends in time, whatever its engine is at.
#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <thread>
#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::cli {

struct Bounded {
  Result<diagnosis::Diagnosis> answer;
  bool ended =
      true;  ///< false: the work still runs in its thread, and the process has to leave by std::_Exit
};

/// Runs `work` in a thread of its own: what it returns or throws, or nothing when `over` is true and it does
/// not end within 0.4 s. Then the process has to leave by std::_Exit, until when what `work` refers to must
/// live.
template <class T>
std::optional<T> unless_over(std::function<T()> work, const std::function<bool()>& over) {
  constexpr auto kLook = std::chrono::milliseconds(20);    // from one look at `over` to the next
  constexpr auto kGrace = std::chrono::milliseconds(400);  // to end by itself, of the 1 s promised
  std::packaged_task<T()> task(std::move(work));
  auto answer = task.get_future();
  std::thread(std::move(task)).detach();
  while (answer.wait_for(kLook) != std::future_status::ready)
    if (over() && answer.wait_for(kGrace) != std::future_status::ready) return std::nullopt;
  return answer.get();
}

/// What is said of recordings, of which perhaps no more than the names are known, when nothing was inferred.
diagnosis::Diagnosis without_a_model(const std::vector<recording::Recording>& recordings);

/// Engines look at Options::stop between steps that may take seconds; when `over` is true and `work` does not
/// end in time (unless_over), the answer is unfinished and without a model.
Bounded within_time(std::function<Result<diagnosis::Diagnosis>()> work,
                    const std::vector<recording::Recording>& recordings, const std::function<bool()>& over);

}  // namespace omniflight::cli
