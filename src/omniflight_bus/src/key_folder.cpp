// Writing a folder of keys: whole or absent, secrets for their owner alone from the first byte.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "omniflight_bus/authority.hpp"
#include "omniflight_bus/security.hpp"

namespace omniflight::bus {
namespace {

namespace fs = std::filesystem;

Failure not_written(const fs::path& path) {
  return bad_input(std::string("cannot be written: ") + std::strerror(errno), path.string(),
                   "Choose another --out");
}

Status write_new(const fs::path& path, const std::string& text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
  if (file < 0) return not_written(path);
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(file, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  const bool whole = done == text.size() && ::fsync(file) == 0;
  const Failure failure = not_written(path);  // takes errno before close
  ::close(file);
  if (!whole) return failure;
  return {};
}

Status write_role(const KeyFiles& files, const Credentials& credentials) {
  if (::mkdir(files.certificate.parent_path().c_str(), 0700) != 0)
    return not_written(files.certificate.parent_path());
  if (auto ok = write_new(files.certificate, credentials.certificate, 0644); !ok) return ok;
  if (auto ok = write_new(files.private_key, credentials.private_key, 0600); !ok) return ok;
  return write_new(files.permissions, credentials.permissions, 0644);
}

Status write_all(const fs::path& folder, const std::map<std::string, Rights>& roles,
                 const Validity& validity) {
  auto authority = Authority::create(validity);
  if (!authority) return Failure(authority.error());
  const auto governance = authority->sign(governance_xml());
  if (!governance) return Failure(governance.error());
  const KeyFiles shared(folder, "");
  if (auto ok = write_new(shared.identity_ca, authority->identity_ca(), 0644); !ok) return ok;
  if (auto ok = write_new(shared.permissions_ca, authority->permissions_ca(), 0644); !ok) return ok;
  if (auto ok = write_new(shared.governance, *governance, 0644); !ok) return ok;
  for (const auto& [role, rights] : roles) {
    const auto credentials = authority->issue(role, rights, validity);
    if (!credentials) return Failure(credentials.error());
    if (auto ok = write_role(KeyFiles(folder, role), *credentials); !ok) return ok;
  }
  return {};
}

}  // namespace

Status write_keys(const fs::path& folder, const std::map<std::string, Rights>& roles,
                  const Validity& validity) {
  std::error_code ec;
  if (fs::exists(fs::symlink_status(folder, ec)))
    return bad_input("is there already; keys are never overwritten", folder.string(),
                     "Choose another --out, or remove it when nobody uses these keys");
  if (validity.until_s <= validity.from_s) return bad_input("must end after it begins", "validity of keys");
  fs::path target = fs::absolute(folder).lexically_normal();
  if (target.filename().empty()) target = target.parent_path();  // "keys/"
  fs::create_directories(target.parent_path(), ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), folder.string(), "Choose another --out");
  const fs::path partial = target.string() + ".partial." + std::to_string(::getpid());
  if (::mkdir(partial.c_str(), 0700) != 0) return not_written(partial);
  Status done = write_all(partial, roles, validity);
  if (done && ::rename(partial.c_str(), target.c_str()) != 0) done = not_written(target);
  if (!done) fs::remove_all(partial, ec);
  return done;
}

}  // namespace omniflight::bus
