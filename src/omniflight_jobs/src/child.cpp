#include "omniflight_jobs/child.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>

namespace omniflight::jobs {

Result<Child> Child::start(const std::string& program, const std::vector<std::string>& arguments,
                           const ChildOptions& options) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const int log = open(options.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log < 0) return bad_input(std::string("cannot be written: ") + std::strerror(errno), options.log);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) {
    close(log);
    return fail(ErrorCode::internal, std::string("cannot start: ") + std::strerror(errno), program);
  }
  if (pid == 0) {
    // a group of its own: Ctrl-C reaches the parent alone, which then stops everything in order
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    if (options.cpu >= 0) {
      cpu_set_t set;
      CPU_ZERO(&set);
      CPU_SET(options.cpu, &set);
      sched_setaffinity(0, sizeof set, &set);
    }
    if (options.prompt) {
      const sched_param priority{.sched_priority = 10};
      (void)sched_setscheduler(0, SCHED_RR, &priority);  // without the right it is scheduled like any other
    }
    execv(program.c_str(), argv.data());
    _exit(127);
  }
  close(log);
  return Child(pid, program.substr(program.find_last_of('/') + 1), options.log);
}

Child::Child(Child&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      name_(std::move(other.name_)),
      log_(std::move(other.log_)),
      exit_(other.exit_) {}

Child::~Child() {
  if (pid_ > 0 && !exit_) terminate(2.0);
}

std::optional<int> Child::poll() {
  if (exit_) return exit_;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) == pid_)
    exit_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return exit_;
}

void Child::ask_to_end() {
  if (!poll()) kill(pid_, SIGTERM);
}

int Child::terminate(double deadline_s) {
  using clock = std::chrono::steady_clock;
  const auto deadline = clock::now() + std::chrono::duration<double>(deadline_s);
  ask_to_end();
  while (!poll()) {
    if (clock::now() > deadline) {
      kill(pid_, SIGKILL);
      int status = 0;
      waitpid(pid_, &status, 0);
      exit_ = 128 + SIGKILL;
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return *exit_;
}

std::string Child::last_words() const {
  std::ifstream in(log_);
  std::string line, last;
  while (std::getline(in, line)) {
    if (line.find("] not ") != std::string::npos) return line;  // the first failure; the rest follows from it
    if (!line.empty()) last = line;
  }
  return last.empty() ? "see " + log_ : last;
}

}  // namespace omniflight::jobs
