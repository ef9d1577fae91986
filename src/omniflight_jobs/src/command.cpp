#include "command.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

namespace omniflight::jobs {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t kMost = 64u << 20;  // bytes

struct Pipe {
  int ends[2] = {-1, -1};
  bool open() { return pipe2(ends, O_CLOEXEC) == 0; }
  ~Pipe() {
    for (const int end : ends)
      if (end >= 0) close(end);
  }
  void shut(int which) {
    if (ends[which] >= 0) close(ends[which]);
    ends[which] = -1;
  }
};

int ended(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Reads both ends until they close. False at the deadline, or when too much comes.
bool read_both(Pipe (&pipes)[2], std::string* (&texts)[2], Clock::time_point deadline) {
  while (pipes[0].ends[0] >= 0 || pipes[1].ends[0] >= 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd fds[2] = {{pipes[0].ends[0], POLLIN, 0}, {pipes[1].ends[0], POLLIN, 0}};
    if (poll(fds, 2, static_cast<int>(left)) < 0 && errno != EINTR) return false;
    for (int k = 0; k < 2; ++k) {
      if (fds[k].fd < 0 || fds[k].revents == 0) continue;
      char buffer[65536];
      const ssize_t n = read(fds[k].fd, buffer, sizeof buffer);
      if (n > 0) texts[k]->append(buffer, static_cast<std::size_t>(n));
      if (n == 0 || (n < 0 && errno != EINTR)) pipes[k].shut(0);
      if (texts[k]->size() > kMost) return false;
    }
  }
  return true;
}

}  // namespace

std::string in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const std::string file = folder + "/" + program; access(file.c_str(), X_OK) == 0) return file;
  return {};
}

Result<Output> run_command(const std::vector<std::string>& command, double deadline_s) {
  std::vector<char*> argv;
  for (const std::string& a : command) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  Pipe pipes[2];
  if (!pipes[0].open() || !pipes[1].open())
    return fail(ErrorCode::internal, std::string("no pipe: ") + std::strerror(errno), command[0]);
  const pid_t pid = fork();
  if (pid < 0)
    return fail(ErrorCode::internal, std::string("cannot start: ") + std::strerror(errno), command[0]);
  if (pid == 0) {
    setpgid(0, 0);  // Ctrl-C is for the one who waits
    const int none = open("/dev/null", O_RDONLY);
    if (none >= 0) dup2(none, STDIN_FILENO);
    dup2(pipes[0].ends[1], STDOUT_FILENO);
    dup2(pipes[1].ends[1], STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  pipes[0].shut(1);
  pipes[1].shut(1);
  Output out;
  std::string* texts[2] = {&out.out, &out.err};
  const auto deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(deadline_s));
  if (!read_both(pipes, texts, deadline)) {
    kill(-pid, SIGKILL);
    (void)ended(pid);
    return fail(ErrorCode::incomplete, fmt::format("gave no answer within {:g} s", deadline_s), command[0]);
  }
  out.code = ended(pid);
  if (out.code == 127) return bad_input("cannot be started", command[0]);
  return out;
}

}  // namespace omniflight::jobs
