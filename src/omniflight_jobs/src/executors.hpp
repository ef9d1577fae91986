// The executors that there are.
#pragma once

#include "omniflight_jobs/executor.hpp"

namespace omniflight::jobs {

/// Why a job has no result when Work::may_begin said no.
inline constexpr const char* kNoTime = "the time was over before it began";

std::unique_ptr<Executor> make_local(const ExecutorOptions& options);
Result<std::unique_ptr<Executor>> make_slurm(const ExecutorOptions& options);

}  // namespace omniflight::jobs
