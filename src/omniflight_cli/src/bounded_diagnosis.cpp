#include "bounded_diagnosis.hpp"

#include <chrono>
#include <future>
#include <thread>

namespace omniflight::cli {
namespace {

using diagnosis::Diagnosis;

constexpr auto kLook = std::chrono::milliseconds(20);  // from one look at `over` to the next
constexpr auto kGrace =
    std::chrono::milliseconds(400);  // for the engine to end by itself, of the 1 s promised

Diagnosis without_a_model(const std::vector<recording::Recording>& recordings) {
  Diagnosis d;
  for (const recording::Recording& r : recordings) {
    diagnosis::Input input{r.file, r.sha256, r.duration_s, {}, {}};
    for (const auto& [name, signal] : r.signals) input.signals.push_back(name);
    d.inputs.push_back(std::move(input));
  }
  diagnosis::mark_unfinished(d);
  d.summary = "Not finished: stopped, or the time was up. Still open: " + d.left_out.front() + ".";
  return d;
}

}  // namespace

Bounded within_time(std::function<Result<Diagnosis>()> work,
                    const std::vector<recording::Recording>& recordings, const std::function<bool()>& over) {
  if (over()) return {without_a_model(recordings), true};  // stopped while the recordings were read
  std::packaged_task<Result<Diagnosis>()> task(std::move(work));
  auto answer = task.get_future();
  std::thread(std::move(task)).detach();
  while (answer.wait_for(kLook) != std::future_status::ready)
    if (over() && answer.wait_for(kGrace) != std::future_status::ready)
      return {without_a_model(recordings), false};
  try {
    return {answer.get(), true};
  } catch (const std::exception& e) {
    if (over()) return {without_a_model(recordings), true};
    return {fail(ErrorCode::internal, std::string("the diagnosis failed: ") + e.what(), "diagnose"), true};
  }
}

}  // namespace omniflight::cli
