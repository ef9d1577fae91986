#include "loopback_sockets.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>

namespace omniflight::bus::detail {
namespace {

bool listens_everywhere(int fd) {
  int type = 0;
  socklen_t size = sizeof type;
  if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return false;
  sockaddr_in address{};
  size = sizeof address;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return false;
  return address.sin_family == AF_INET && address.sin_port != 0 &&
         address.sin_addr.s_addr == htonl(INADDR_ANY);
}

}  // namespace

std::set<int> sockets_on_all_interfaces() {
  std::set<int> out;
  std::error_code ec;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", ec)) {
    const std::string name = entry.path().filename().string();
    int fd = -1;
    std::from_chars(name.data(), name.data() + name.size(), fd);
    if (fd >= 0 && listens_everywhere(fd)) out.insert(fd);
  }
  return out;
}

Status confine_to_loopback(const std::set<int>& before) {
  constexpr char kDevice[] = "lo";
  for (const int fd : sockets_on_all_interfaces()) {
    if (before.contains(fd)) continue;
    if (setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, kDevice, sizeof kDevice) != 0)
      return fail(ErrorCode::internal, std::string("a socket cannot be bound to lo: ") + std::strerror(errno),
                  "bus", "Linux 5.7 or newer is needed, or OMNIFLIGHT_BUS=FILE to use the network knowingly");
  }
  return {};
}

}  // namespace omniflight::bus::detail
