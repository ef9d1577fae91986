// What Slurm's commands print, read. No command is run here.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::jobs {

/// A task of an array as squeue tells it.
struct QueuedTask {
  std::size_t number = 0;
  std::string state, reason, nodes;  ///< "RUNNING", "PENDING", ...; "Resources", ...; "node1"
  int restarts = 0;                  ///< how often the cluster has begun it again
};

/// Of `squeue --noheader --array --Format=ArrayTaskID:|,State:|,Reason:|,NodeList:|,RestartCnt:|`. Lines that
/// are none of that form are left out.
std::vector<QueuedTask> read_queue(const std::string& text);
inline constexpr const char* kQueueFormat = "ArrayTaskID:|,State:|,Reason:|,NodeList:|,RestartCnt:|";

/// How a task ended, in words: "NODE_FAIL on node2".
using Endings = std::map<std::size_t, std::string>;
/// Of `sacct --parsable2 --noheader --allocations --format=JobID,State,ExitCode,NodeList`.
Endings read_accounting(const std::string& text);
/// Of `scontrol show job ID`.
Endings read_jobs(const std::string& text);

/// MaxArraySize of `scontrol show config`; 0: not told.
std::size_t largest_array(const std::string& config);

/// What sbatch said, as an error that names the option that it is about and what can be done.
Error refusal(const std::string& said);

/// Why tasks that wait with this reason will wait for ever.
struct Blocked {
  Error error;            ///< an empty message: they need not
  double patience_s = 0;  ///< how long the reason must stand: some are also told while nodes are down
};
Blocked blocked(const std::string& reason);
/// The task was put on hold, by an administrator or because it could not be launched.
bool is_held(const std::string& reason);

/// Text as one word of a POSIX shell.
std::string shell_word(const std::string& text);

}  // namespace omniflight::jobs
