// Who runs the jobs: this machine, or a cluster under Slurm.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "omniflight_jobs/job.hpp"

namespace omniflight::jobs {

struct ExecutorOptions {
  std::string name = "local";  ///< local | slurm
  int jobs = 0;                ///< local: at once; 0: processors
  // slurm; empty and 0: what the cluster does without being told
  std::string partition = {}, account = {};
  double time_min = 0;    ///< of a task of the array
  int cpus = 1;           ///< of a task
  int tasks_at_once = 0;  ///< of the array
  int jobs_per_task = 0;  ///< 0: as few as the largest array allows
  int attempts = 3;       ///< arrays that are submitted for jobs which left no result
  double wait_h = 168;    ///< until the work is given up

  /// Jobs at once on this machine.
  int at_once() const {
    return jobs > 0 ? jobs : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  }
};

/// What the executor is to run, and who is told.
struct Work {
  std::vector<Job> jobs;
  std::string program;                ///< absolute; runs the jobs' commands
  std::vector<std::string> run_task;  ///< arguments of the program that end in run_task(), see task.hpp
  std::filesystem::path folder;       ///< absolute, shared by all machines; takes what the executor writes
  bool (*stop)() = nullptr;           ///< ends what runs
  std::function<bool()> may_begin;    ///< once false, nothing more is begun; empty: always true
  std::function<void(std::size_t done)> progress;  ///< called one at a time
  std::function<void(const std::string&)> say;     ///< a line for people
};

/// What became of a job that has no result.
struct Missing {
  std::size_t job = 0;  ///< place in Work::jobs
  std::string reason;
};

struct Ran {
  std::size_t before = 0, made = 0;  ///< results that were there, and those that came
  std::vector<Missing> missing;
  bool stopped = false;
  // s of wall time: what one machine does for all jobs, and their work itself
  double submit_s = 0, work_s = 0, collect_s = 0;
  int arrays = 0, requeued = 0;  ///< slurm: submitted; tasks that the cluster began again by itself
  std::vector<std::string> remarks;
};

class Executor {
 public:
  virtual ~Executor() = default;
  /// Jobs whose folder is there are left alone. Returns when every job has a result or a reason.
  /// Errors: bad_input when the work cannot be begun at all, naming the option.
  virtual Result<Ran> run(const Work& work) = 0;
};

/// The options as arguments of another program that has them.
std::vector<std::string> arguments_of(const ExecutorOptions& options);

/// Errors: an unknown name; slurm without its programs, or with a controller that does not answer.
Result<std::unique_ptr<Executor>> make_executor(const ExecutorOptions& options);

}  // namespace omniflight::jobs
