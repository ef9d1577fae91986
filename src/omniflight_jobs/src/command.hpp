// A short program whose output is wanted, with a deadline.
#pragma once

#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::jobs {

struct Output {
  int code = 0;  ///< exit code; 128 + signal
  std::string out, err;
};

/// Runs it and waits. It is killed at the deadline [s] (incomplete, naming it) and when it writes more than
/// 64 MB. Errors: bad_input when it cannot be started.
Result<Output> run_command(const std::vector<std::string>& command, double deadline_s);

/// Full path of a program in PATH; empty: it is not there.
std::string in_path(const std::string& program);

}  // namespace omniflight::jobs
