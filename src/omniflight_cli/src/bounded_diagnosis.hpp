// A diagnosis that ends in time, whatever its engine is at.
#pragma once

#include <functional>
#include <vector>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::cli {

struct Bounded {
  Result<diagnosis::Diagnosis> answer;
  bool ended =
      true;  ///< false: the work still runs in its thread, and the process has to leave by std::_Exit
};

/// Runs `work` in a thread of its own. Engines look at Options::stop between steps that may take seconds;
/// when `over` is true and the work does not end within 0.4 s, the answer is unfinished and without a model.
/// What `work` refers to must live until the process ends when it has not ended.
Bounded within_time(std::function<Result<diagnosis::Diagnosis>()> work,
                    const std::vector<recording::Recording>& recordings, const std::function<bool()>& over);

}  // namespace omniflight::cli
