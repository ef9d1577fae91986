#include "omniflight_bus/domain.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "bus_configuration.hpp"
#include "omniflight_bus/participant.hpp"

namespace omniflight::bus {
namespace {

const std::string kKeys = "keys ";  // begins the line of a lock that names the keys of its run

std::string lock_path(int domain) {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code ignored;
  const bool usable =
      runtime != nullptr && *runtime == '/' && std::filesystem::is_directory(runtime, ignored);
  return std::string(usable ? runtime : "/tmp") + "/omniflight-domain-" + std::to_string(domain) + ".lock";
}

}  // namespace

DomainClaim::DomainClaim(DomainClaim&& other) noexcept
    : domain_(std::exchange(other.domain_, -1)), file_(std::exchange(other.file_, -1)) {}
DomainClaim& DomainClaim::operator=(DomainClaim&& other) noexcept {
  std::swap(domain_, other.domain_);
  std::swap(file_, other.file_);
  return *this;
}
DomainClaim::~DomainClaim() {
  if (file_ >= 0) close(file_);
}

Result<DomainClaim> claim_domain(int domain) {
  if (domain < 0 || domain > max_domain) {
    return bad_input("domain " + std::to_string(domain) + " does not exist", "domain",
                     "Choose 0 to " + std::to_string(max_domain));
  }
  const std::string path = lock_path(domain);
  // The file stays: removing it would let two runs lock two files of one name.
  int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file < 0 && errno == EACCES)
    file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);  // another user's
  if (file < 0) {
    return fail(ErrorCode::internal,
                std::string("cannot open the lock of the domain: ") + std::strerror(errno), path,
                "Set XDG_RUNTIME_DIR to a directory that can be written");
  }
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    char owner[32] = {};
    const ssize_t n = pread(file, owner, sizeof(owner) - 1, 0);
    close(file);
    if (reason != EWOULDBLOCK) {
      return fail(ErrorCode::internal, std::string("cannot lock the domain: ") + std::strerror(reason), path);
    }
    return bad_input("domain " + std::to_string(domain) + " is in use by another run" +
                         (n > 0 ? " (process " + std::to_string(std::atol(owner)) + ")" : std::string()),
                     path, "Wait for it to end or choose another domain");
  }
  const std::string owner = std::to_string(getpid()) + "\n";
  if (ftruncate(file, 0) == 0) {  // only tells people who holds it; the lock itself is what counts
    [[maybe_unused]] const ssize_t written = pwrite(file, owner.data(), owner.size(), 0);
  }
  return DomainClaim(domain, file);
}

Result<DomainClaim> claim_free_domain(int first, int last) {
  for (int domain = first; domain <= last; ++domain) {
    Result<DomainClaim> claim = claim_domain(domain);
    if (claim || claim.error().code != ErrorCode::bad_input) return claim;
  }
  return bad_input(
      "every domain from " + std::to_string(first) + " to " + std::to_string(last) + " is in use", "domain",
      "Wait for another run to end");
}

void DomainClaim::tell_keys(const std::string& folder) const {
  const std::string text = std::to_string(getpid()) + "\n" + kKeys + folder + "\n";
  if (file_ < 0 || ftruncate(file_, 0) != 0) return;  // whoever asks is then told to name them himself
  [[maybe_unused]] const ssize_t written = pwrite(file_, text.data(), text.size(), 0);
}

std::string keys_of_run(int domain) {
  if (domain < 0) return {};
  if (claim_domain(domain)) return {};  // nobody flies there; what the file says is of an earlier run
  const int file = open(lock_path(domain).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return {};
  struct stat info {};
  char text[4096] = {};
  const bool ours = fstat(file, &info) == 0 && info.st_uid == geteuid();
  const ssize_t n = ours ? pread(file, text, sizeof text - 1, 0) : 0;
  close(file);
  const std::string said(text, n > 0 ? static_cast<std::size_t>(n) : 0);
  const auto begin = said.find(kKeys);
  const auto end = said.find('\n', begin);
  if (begin == std::string::npos || end == std::string::npos) return {};
  return said.substr(begin + kKeys.size(), end - begin - kKeys.size());
}

namespace {
bool g_loopback = false;
std::string g_file, g_added;  // parts of CYCLONEDDS_URI

std::string configuration() { return g_added.empty() ? g_file : g_file + "," + g_added; }
}  // namespace

Status use_loopback(const std::string& xml_file) {
  const char* chosen = std::getenv("OMNIFLIGHT_BUS");
  const bool another = chosen != nullptr && *chosen != '\0';
  std::error_code error;
  const std::filesystem::path path = std::filesystem::canonical(another ? chosen : xml_file, error);
  if (error)
    return bad_input("cannot be read: " + error.message(),
                     another ? "OMNIFLIGHT_BUS=" + std::string(chosen) : xml_file,
                     "Name a Cyclone DDS configuration file");
  const std::string uri = "file://" + path.string();
  const char* present = std::getenv("CYCLONEDDS_URI");
  if (present != nullptr && *present != '\0' && uri != present && configuration() != present)
    std::fprintf(
        stderr,
        "[bus] CYCLONEDDS_URI=%s is not used, this run uses %s; OMNIFLIGHT_BUS=FILE chooses another\n",
        present, uri.c_str());
  g_file = uri;
  setenv("CYCLONEDDS_URI", configuration().c_str(), 1);
  g_loopback = !another;
  return {};
}

Status detail::add_configuration(const std::string& xml) {
  if (g_file.empty())
    return fail(ErrorCode::internal, "keys are used before use_loopback has chosen a configuration", "bus");
  g_added = xml;
  setenv("CYCLONEDDS_URI", configuration().c_str(), 1);
  return {};
}

bool loopback_promised() { return g_loopback; }

}  // namespace omniflight::bus
