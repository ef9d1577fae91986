#include "omniflight_report/write_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace omniflight::report {
namespace {

namespace fs = std::filesystem;

Failure failed(const char* action, const fs::path& path, int error) {
  const bool space = error == ENOSPC || error == EDQUOT || error == EFBIG;
  return fail(ErrorCode::bad_input, std::string("cannot ") + action + ": " + std::strerror(error),
              path.string(),
              space ? "Free some space or write elsewhere" : "Check the path and its permissions");
}

Status write_all(int descriptor, std::string_view content, const fs::path& path) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return failed("write", path, errno);
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Status write_and_close(int descriptor, std::string_view content, const fs::path& path, bool sync) {
  Status status = write_all(descriptor, content, path);
  if (status && sync && ::fsync(descriptor) != 0) status = failed("sync", path, errno);
  // Some file systems report a full disk only here.
  if (::close(descriptor) != 0 && status) status = failed("close", path, errno);
  return status;
}

}  // namespace

Status write_file(const fs::path& path, std::string_view content) {
  std::error_code error;
  const fs::path target =
      fs::weakly_canonical(fs::absolute(path), error);  // a link keeps pointing at its file
  if (error) return failed("find", path, error.value());
  const auto kind = fs::status(target, error).type();
  if (kind == fs::file_type::directory) return failed("write", path, EISDIR);
  if (kind != fs::file_type::regular && kind != fs::file_type::not_found) {
    const int device = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (device < 0) return failed("open", path, errno);
    return write_and_close(device, content, path, false);
  }
  const fs::path folder = target.parent_path();
  if (!fs::is_directory(folder, error)) {
    return bad_input("the folder does not exist", folder.string(), "Create it first");
  }
  const fs::path part = target.string() + ".part" + std::to_string(::getpid());
  const int descriptor = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (descriptor < 0) return failed("create", part, errno);
  Status status = write_and_close(descriptor, content, path, true);
  if (status && ::rename(part.c_str(), target.c_str()) != 0) status = failed("rename", path, errno);
  if (!status) ::unlink(part.c_str());
  return status;
}

}  // namespace omniflight::report
