#include "folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
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
  if (auto ok = make_folder(folder.string()); !ok) return Failure(ok.error());
  const fs::path file = folder / FolderLock::kFile;
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (fd < 0) return bad_input(std::string("cannot be locked: ") + std::strerror(errno), file.string());
  FolderLock lock(fd);
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return bad_input("is in use by another run" + holder(fd), folder.string(),
                     "Wait for its end, or choose another --out");
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(fd, 0) != 0 || pwrite(fd, pid.data(), pid.size(), 0) < 0)
    return bad_input(std::string("cannot be written: ") + std::strerror(errno), file.string(),
                     "Free space on the disk or choose another --out");
  return lock;
}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

// The file stays: removed while another run waits for it, it would let two in.
FolderLock::~FolderLock() {
  if (fd_ >= 0) close(fd_);
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
