// Slurm's own commands, each with a deadline: sbatch, squeue, scancel, scontrol, and sacct where there is an
// accounting.
#pragma once

#include <optional>

#include "omniflight_jobs/executor.hpp"
#include "slurm_text.hpp"

namespace omniflight::jobs {

class SlurmCommands {
 public:
  /// Errors: a command is not in PATH, or the controller does not answer.
  static Result<SlurmCommands> find();

  std::size_t largest_array() const { return largest_array_; }
  /// Submits the script as an array of `tasks`; the id. Errors: the cluster's refusal.
  Result<std::string> submit(const ExecutorOptions& options, std::size_t tasks,
                             const std::filesystem::path& script, const std::filesystem::path& log) const;
  /// Tasks that wait or run; none when the cluster does not know the array any more.
  Result<std::vector<QueuedTask>> queue(const std::string& id) const;
  /// How the tasks of an array ended, as far as it is known. remark: what the words are from, where that is
  /// not the accounting.
  Endings endings(const std::string& id, std::string& remark) const;
  void cancel(const std::string& id) const;

 private:
  std::string sbatch_, squeue_, scancel_, scontrol_, sacct_;
  std::size_t largest_array_ = 0;
};

}  // namespace omniflight::jobs
