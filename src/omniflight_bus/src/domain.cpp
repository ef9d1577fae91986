#include "omniflight_bus/domain.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "omniflight_bus/participant.hpp"

namespace omniflight::bus {
namespace {

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

namespace {
bool g_loopback = false;
}

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
  if (present != nullptr && *present != '\0' && uri != present)
    std::fprintf(
        stderr,
        "[bus] CYCLONEDDS_URI=%s is not used, this run uses %s; OMNIFLIGHT_BUS=FILE chooses another\n",
        present, uri.c_str());
  setenv("CYCLONEDDS_URI", uri.c_str(), 1);
  g_loopback = !another;
  return {};
}

bool loopback_promised() { return g_loopback; }

}  // namespace omniflight::bus
