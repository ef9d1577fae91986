#include "omniflight_gateway/local_socket.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace omniflight::gateway {
namespace {

/// Bytes of kernel memory that commands may take up on their way: about ten commands.
constexpr int kCommandBuffer = 8192;

/// A socket's address holds 107 characters; through an open directory a path may be as long as the system
/// allows.
struct Address {
  FileDescriptor directory;
  sockaddr_un name{};
};

Failure failure(const std::string& what, const std::string& path, const std::string& next) {
  return bad_input(what + ": " + std::strerror(errno), path, next);
}

Result<Address> address_of(const std::string& path) {
  const std::filesystem::path whole(path);
  const std::string parent = whole.has_parent_path() ? whole.parent_path().string() : ".";
  Address a;
  a.directory = FileDescriptor(::open(parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!a.directory.is_open())
    return failure("cannot open the directory of the board's socket", path, "Give an existing directory");
  const std::string name =
      "/proc/self/fd/" + std::to_string(a.directory.get()) + "/" + whole.filename().string();
  if (name.size() >= sizeof a.name.sun_path)
    return bad_input("the socket's name is too long", path, "Give a name of at most 80 characters");
  a.name.sun_family = AF_UNIX;
  std::memcpy(a.name.sun_path, name.c_str(), name.size() + 1);
  return a;
}

FileDescriptor open_socket() {
  return FileDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

}  // namespace

bool is_local_socket(const std::string& path) {
  struct stat s {};
  return ::stat(path.c_str(), &s) == 0 && S_ISSOCK(s.st_mode);
}

Result<FileDescriptor> listen_local(const std::string& path) {
  const std::string next = "Give an existing, writable directory and a free name";
  const auto address = address_of(path);
  if (!address) return Failure(address.error());
  struct stat left {};
  // a socket or the link to a pseudo terminal, left behind by a killed run
  if (::lstat(path.c_str(), &left) == 0 && (S_ISSOCK(left.st_mode) || S_ISLNK(left.st_mode)))
    ::unlink(path.c_str());
  FileDescriptor fd = open_socket();
  if (!fd.is_open()) return failure("cannot open a socket", path, "Check the limit of open files");
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address->name), sizeof address->name) != 0 ||
      ::listen(fd.get(), 1) != 0)
    return failure("cannot listen for the board's host", path, next);
  return fd;
}

FileDescriptor accept_local(const FileDescriptor& listener) {
  return FileDescriptor(::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

Result<FileDescriptor> connect_local(const std::string& path) {
  const auto address = address_of(path);
  if (!address) return Failure(address.error());
  FileDescriptor fd = open_socket();
  if (!fd.is_open()) return failure("cannot open a socket", path, "Check the limit of open files");
  (void)::setsockopt(fd.get(), SOL_SOCKET, SO_SNDBUF, &kCommandBuffer, sizeof kCommandBuffer);
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address->name), sizeof address->name) != 0)
    return failure("cannot connect to the board's socket", path, "Check that the emulator runs");
  return fd;
}

}  // namespace omniflight::gateway
