#include "bounded_diagnosis.hpp"

namespace omniflight::cli {

using diagnosis::Diagnosis;

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

Bounded within_time(std::function<Result<Diagnosis>()> work,
                    const std::vector<recording::Recording>& recordings, const std::function<bool()>& over) {
  if (over()) return {without_a_model(recordings), true};  // stopped while the recordings were read
  try {
    auto answer = unless_over(std::move(work), over);
    if (!answer) return {without_a_model(recordings), false};
    return {std::move(*answer), true};
  } catch (const std::exception& e) {
    if (over()) return {without_a_model(recordings), true};
    return {fail(ErrorCode::internal, std::string("the diagnosis failed: ") + e.what(), "diagnose"), true};
  }
}

}  // namespace omniflight::cli
