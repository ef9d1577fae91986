// A job: one run of this program that leaves one folder. However often it is started, by whomever, its folder
// appears once and whole.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::jobs {

/// In a command, stands for the folder to write into.
inline constexpr const char* kOut = "{out}";

struct Job {
  std::string name;                  ///< in messages; no two of a run have the same
  std::filesystem::path folder;      ///< absolute; where the result appears
  std::vector<std::string> command;  ///< arguments of the program, with kOut
  std::vector<int> results = {0};    ///< exit codes with which what was written is a result
};

enum class Ending {
  done,         ///< the result was made by this call
  done_before,  ///< it was there, or somebody else was quicker
  failed,       ///< the program ended with another exit code, or could not be started
  killed,       ///< the program was ended by a signal: another attempt may do better
  stopped,      ///< by stop()
};
struct Performed {
  Ending ending = Ending::failed;
  std::string reason;  ///< why it failed
  double seconds = 0;  ///< of the program
};

/// Runs the job here and waits for it. It writes into a folder `.partial-...` beside FOLDER that is named
/// after job, host, process and number, and is renamed to FOLDER when the program ended well. rename(2) of a
/// folder onto one that is not empty fails, so of two that do the same job the second throws its own away.
/// Inside is job.json: host, node, seconds, exit code. After a failure nothing is left but the reason.
Performed perform(const Job& job, const std::string& program, bool (*stop)());

/// Whether the result is there.
bool is_done(const Job& job);

/// The same of many jobs, by reading each parent folder once: a network file system may answer for a single
/// folder from its cache that it is not there, long after another machine has made it.
std::vector<char> are_done(const std::vector<Job>& jobs);

/// Removes what attempts left unfinished beside jobs that are done. One pass over each parent folder.
void remove_partials(const std::vector<Job>& jobs);

}  // namespace omniflight::jobs
