#include "prove_sandbox.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "omniflight_files/files.hpp"

namespace omniflight::proof {

namespace fs = std::filesystem;

namespace {

constexpr uid_t kNobody = 65534;
constexpr gid_t kNogroup = 65534;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool put(const char* file, const std::string& text) {
  const int fd = open(file, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool ok = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  return (close(fd) == 0) && ok;
}

/// An empty file system over a folder, seen by this process and its children only.
bool hide(const fs::path& folder) {
  return mount("hidden", folder.c_str(), "tmpfs", MS_NOSUID | MS_NODEV | MS_NOEXEC | MS_RDONLY,
               "size=4k,mode=000") == 0;
}

bool hide_in_namespace(const fs::path& seal) {
  if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return false;
  if (!hide(seal)) return false;
  hide("/proc");  // other processes' views of the seal; what cannot be hidden is caught by the probe
  return true;
}

/// In the child, before exec: true when it is confined as asked.
bool confine(Confinement how, const fs::path& seal) {
  if (how == Confinement::other_user) {
    if (unshare(CLONE_NEWNS) == 0) hide_in_namespace(seal);  // a second wall; the first is the user
    const gid_t group = kNogroup;
    if (setgroups(1, &group) != 0 || setgid(kNogroup) != 0 || setuid(kNobody) != 0) return false;
    if (setuid(0) == 0) return false;
  } else if (how == Confinement::namespaces) {
    const uid_t user = geteuid();
    const gid_t group = getegid();
    prctl(PR_SET_DUMPABLE, 1, 0, 0, 0);  // else its own maps are not writable
    if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    put("/proc/self/setgroups", "deny");
    if (!put("/proc/self/uid_map", std::to_string(user) + " " + std::to_string(user) + " 1") ||
        !put("/proc/self/gid_map", std::to_string(group) + " " + std::to_string(group) + " 1") ||
        !hide_in_namespace(seal))
      return false;
  }
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0;
}

/// Does it work here? Tried in a child that ends at once.
bool works(Confinement how, const fs::path& seal) {
  const pid_t pid = fork();
  if (pid < 0) return false;
  if (pid == 0) _exit(confine(how, seal) ? 0 : 1);
  int status = 0;
  return waitpid(pid, &status, 0) == pid && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::string to_string(Confinement c) {
  switch (c) {
    case Confinement::other_user:
      return "another user (nobody), seal of mode 700, hidden mount where allowed";
    case Confinement::namespaces:
      return "user and mount namespaces with an empty file system over the seal";
    case Confinement::none:
      break;
  }
  return "none: the analysis could have read the truth";
}

Result<Confinement> choose_confinement(const fs::path& seal, bool allow_unsealed) {
  const Confinement best = geteuid() == 0 ? Confinement::other_user : Confinement::namespaces;
  if (works(best, seal)) return best;
  if (allow_unsealed) return Confinement::none;
  return fail(
      ErrorCode::bad_input, "the analysis cannot be kept from the seal here", seal.string(),
      "Run as root, or where user namespaces are allowed, or with --allow-unsealed (the result says so)");
}

Result<ConfinedChild> ConfinedChild::start(const Confined& what) {
  if (what.arguments.empty()) return fail(ErrorCode::internal, "no program to run", "sandbox");
  std::vector<std::string> arguments = what.arguments;
  std::vector<char*> argv;
  for (auto& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  std::string path = "PATH=/usr/bin:/bin", home = "HOME=/nonexistent", lang = "LC_ALL=C";
  // with /proc hidden a program does not know where it lies, and so finds its configs by this alone
  const auto found = files::config_dir();
  std::string configs = found ? "OMNIFLIGHT_CONFIGS=" + fs::absolute(*found).string() : "";
  char* environment[] = {path.data(), home.data(), lang.data(), found ? configs.data() : nullptr, nullptr};
  ConfinedChild child;
  child.begin_ = now();
  child.limit_ = what.limit_s;
  const pid_t pid = fork();
  if (pid < 0) return fail(ErrorCode::internal, std::string("no process: ") + strerror(errno), arguments[0]);
  if (pid == 0) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int null = open("/dev/null", O_RDONLY);
    const int log =
        open(what.log.empty() ? "/dev/null" : what.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (null < 0 || log < 0) _exit(125);
    dup2(null, 0);
    dup2(log, 1);
    dup2(log, 2);
    for (int fd = 3; fd < 1024; ++fd) close(fd);  // nothing that was open is inherited
    signal(SIGINT, SIG_IGN);
    if (!confine(what.confinement, what.seal)) _exit(125);
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // changing the user cleared it
    execve(argv[0], argv.data(), environment);
    _exit(127);
  }
  child.pid_ = pid;
  return child;
}

ConfinedChild::ConfinedChild(ConfinedChild&& o) noexcept { *this = std::move(o); }
ConfinedChild& ConfinedChild::operator=(ConfinedChild&& o) noexcept {
  std::swap(pid_, o.pid_);
  std::swap(code_, o.code_);
  std::swap(begin_, o.begin_);
  std::swap(limit_, o.limit_);
  std::swap(seconds_, o.seconds_);
  std::swap(late_, o.late_);
  return *this;
}
ConfinedChild::~ConfinedChild() {
  if (pid_ < 0) return;
  kill(-pid_, SIGKILL);
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool ConfinedChild::poll() {
  if (pid_ < 0) return true;
  int status = 0;
  const pid_t ended = waitpid(pid_, &status, WNOHANG);
  seconds_ = now() - begin_;
  if (ended == 0) {
    if (seconds_ > limit_ && !late_) {
      late_ = true;
      kill(-pid_, SIGKILL);
      kill(pid_, SIGKILL);
    }
    return false;
  }
  code_ =
      ended == pid_ && WIFEXITED(status) ? WEXITSTATUS(status) : 128 + (ended == pid_ ? WTERMSIG(status) : 0);
  kill(-pid_, SIGKILL);  // whatever it left behind
  pid_ = -1;
  return true;
}

Result<int> run_confined(const Confined& what) {
  auto child = ConfinedChild::start(what);
  if (!child) return Failure(child.error());
  while (!child->poll()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return child->exit_code();
}

ProbeResult probe(const fs::path& seal, const fs::path& secret_file, const fs::path& readable,
                  const fs::path& writable, int parent) {
  ProbeResult r;
  const auto try_to = [&](const std::string& what, bool succeeded) {
    const std::string why = strerror(errno);
    (succeeded ? r.leaks : r.refusals).push_back(succeeded ? what : what + ": " + why);
  };
  const auto opens = [](const fs::path& file) {
    const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return false;
    char c = 0;
    const bool read_one = read(fd, &c, 1) == 1;
    close(fd);
    return read_one;
  };
  const auto through = [&](const std::string& process) {
    return fs::path("/proc/" + process + "/root" + secret_file.string());
  };
  errno = 0;
  try_to("open the sealed file", opens(secret_file));
  std::error_code ec;
  const fs::directory_iterator list(seal, ec);
  errno = ec.value();
  try_to("list the seal", !ec && list != fs::directory_iterator());
  errno = 0;
  try_to("open it through its parent's root", opens(through(std::to_string(parent))));
  try_to("open it through the first process's root", opens(through("1")));
  const bool unmounted = umount2(seal.c_str(), MNT_DETACH) == 0;
  try_to("take the empty file system away", unmounted && opens(secret_file));
  try_to("become root", setuid(0) == 0 && opens(secret_file));
  // seized, not attached: a parent that is attached would stop; it is let go when this process ends
  try_to("trace its parent", ptrace(PTRACE_SEIZE, parent, nullptr, nullptr) == 0);
  const bool unshared = unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0;
  try_to("get out by another namespace",
         unshared && (umount2(seal.c_str(), MNT_DETACH) == 0 || true) && opens(secret_file));
  if (!opens(readable)) r.hindered.push_back("cannot read " + readable.string());
  const fs::path trial = writable / "probe";
  if (std::ofstream file(trial); !(file << "x") || !file.flush())
    r.hindered.push_back("cannot write into " + writable.string());
  unlink(trial.c_str());
  return r;
}

}  // namespace omniflight::proof
