// A task of a job array: several jobs, one after another, on whichever machine it was started.
#pragma once

#include <optional>
#include <vector>

#include "omniflight_jobs/job.hpp"

namespace omniflight::jobs {

/// The jobs of an array and which of them each task does. One file, read by every task.
struct JobArray {
  std::string program;
  std::vector<Job> jobs;
  std::vector<std::vector<std::size_t>> tasks;  ///< places in `jobs`
};

Status write_array(const JobArray& array, const std::filesystem::path& file);
/// Refuses a file that is damaged, naming the field.
Result<JobArray> read_array(const std::filesystem::path& file);

/// Does the jobs of task `number` that have no result yet. A job that fails leaves its reason in
/// FILE.failed/NAME.json, and the task goes on. Returns the exit code: 0 when every job of the task has a
/// result, else 2.
Result<int> run_task(const std::filesystem::path& file, std::size_t number, bool (*stop)());

/// run_task() as the whole of a program: installs the interrupt handler, prints errors, returns the exit
/// code.
int run_task_main(const std::string& file, const std::string& number);

/// What run_task left of a job that has no result; nothing when it was not come to.
struct TaskFailure {
  std::string reason;
  bool killed = false;  ///< by a signal
};
std::optional<TaskFailure> failure_of(const Job& job, const std::filesystem::path& file);

}  // namespace omniflight::jobs
