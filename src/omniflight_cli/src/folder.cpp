#include "folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "verbs.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;
constexpr const char* kLockFile = ".lock";
constexpr int kAttempts = 10;

/// Whether an open file is the one that is at a path now.
bool is_at(int fd, const fs::path& file) {
  struct stat here = {}, there = {};
  return fstat(fd, &here) == 0 && stat(file.c_str(), &there) == 0 && here.st_ino == there.st_ino &&
         here.st_dev == there.st_dev;
}

bool holds_only_the_lock(const fs::path& folder) {
  std::error_code ec;
  int files = 0;
  for (fs::directory_iterator at(folder, ec), end; !ec && at != end; at.increment(ec)) ++files;
  return !ec && files == 1;
}

std::string holder(int fd) {
  char text[32] = {};
  const ssize_t n = pread(fd, text, sizeof text - 1, 0);
  std::string pid;
  for (ssize_t i = 0; i < n && std::isdigit(static_cast<unsigned char>(text[i])) != 0; ++i) pid += text[i];
  return pid.empty() ? "" : " (process " + pid + ")";
}

}  // namespace

std::string fresh_folder(const std::string& name) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  const std::string base = "runs/" + name + "-" + stamp;
  std::string folder = base;
  std::error_code ec;
  for (int k = 2; fs::exists(folder, ec); ++k) folder = base + "-" + std::to_string(k);
  return folder;
}

Result<FolderLock> FolderLock::take(const fs::path& folder) {
  const fs::path file = folder / kLockFile;
  // again where another run has removed its folder between two of these steps
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::error_code ec;
    const bool made = !fs::exists(folder, ec);
    if (auto ok = make_folder(folder.string()); !ok) return Failure(ok.error());
    const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (fd < 0 && errno == ENOENT) continue;
    if (fd < 0) return bad_input(std::string("cannot be locked: ") + std::strerror(errno), file.string());
    FolderLock lock(fd);
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
      return bad_input("is in use by another run" + holder(fd), folder.string(),
                       "Wait for its end, or choose another --out");
    }
    if (!is_at(fd, file)) continue;
    const std::string pid = std::to_string(getpid()) + "\n";
    if (ftruncate(fd, 0) != 0 || pwrite(fd, pid.data(), pid.size(), 0) < 0)
      return bad_input(std::string("cannot be written: ") + std::strerror(errno), file.string(),
                       "Free space on the disk or choose another --out");
    if (made) lock.made_ = folder;
    return lock;
  }
  return bad_input("is made and removed by other runs", folder.string(), "Choose another --out");
}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(made_, other.made_);
  return *this;
}

// The file of a folder with results stays. Removed while it is locked, it lets nobody in beside another: who
// has waited for it sees that it is no longer there.
FolderLock::~FolderLock() {
  if (fd_ < 0) return;
  std::error_code ec;
  if (!made_.empty() && holds_only_the_lock(made_)) {
    fs::remove(made_ / kLockFile, ec);
    fs::remove(made_, ec);
  }
  close(fd_);
}

Status refuse_overwriting(const fs::path& file, bool force) {
  std::error_code ec;
  if (force || !fs::exists(fs::symlink_status(file, ec))) return {};
  return bad_input("is there already and is not overwritten", file.string(),
                   "Choose another --out, or give --force");
}

namespace {
bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || (c != 0 && std::strchr("_.@+-", c));
}
}  // namespace

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.size() <= 100 && name.front() != '.' && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), is_plain);
}

std::string plain_name(std::string name) {
  name = name.substr(0, 100);
  for (char& c : name)
    if (!is_plain(c)) c = '_';
  if (name.empty() || name.front() == '.' || name.front() == '-') name.insert(0, "_");
  return name;
}

}  // namespace omniflight::cli
