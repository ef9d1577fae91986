#include "omniflight_gateway/udp_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cmath>
#include <cstring>

namespace omniflight::gateway {
namespace {

Failure failure(const std::string& what, const std::string& where) {
  return bad_input(what + ": " + std::strerror(errno), where,
                   "See whether the address is of this machine and the port is free");
}

sockaddr_in socket_address(const UdpAddress& a) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(a.port);
  out.sin_addr.s_addr = a.host;
  return out;
}

Result<FileDescriptor> open_bound(const UdpAddress& at, bool shared, const std::string& where) {
  FileDescriptor fd(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!fd.is_open()) return failure("cannot open a socket", where);
  const int yes = 1;
  if (shared && ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0)
    return failure("cannot share the port", where);
  const sockaddr_in address = socket_address(at);
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return failure("cannot receive there", where);
  return fd;
}

}  // namespace

Result<UdpAddress> udp_address(const std::string& host, int port) {
  UdpAddress out;
  in_addr address{};
  if (::inet_pton(AF_INET, host.c_str(), &address) != 1)
    return bad_input("'" + host + "' is no IPv4 address", "host", "For instance 192.168.1.2");
  if (port < 0 || port > 65535) return bad_input("port " + std::to_string(port) + " does not exist", "port");
  out.host = address.s_addr;
  out.port = static_cast<std::uint16_t>(port);
  return out;
}

Result<UdpSocket> UdpSocket::bind(const std::string& interface, int port) {
  const std::string where = interface + ":" + std::to_string(port);
  const auto at = udp_address(interface, port);
  if (!at) return Failure(at.error());
  auto fd = open_bound(*at, false, where);
  if (!fd) return Failure(fd.error());
  in_addr out{};
  out.s_addr = at->host;
  // where multicast leaves, and that this machine hears it too
  if (::setsockopt(fd->get(), IPPROTO_IP, IP_MULTICAST_IF, &out, sizeof out) != 0)
    return failure("cannot send multicast", where);
  sockaddr_in bound{};
  socklen_t size = sizeof bound;
  if (::getsockname(fd->get(), reinterpret_cast<sockaddr*>(&bound), &size) != 0)
    return failure("cannot tell the port", where);
  return UdpSocket(std::move(*fd), ntohs(bound.sin_port));
}

Result<UdpSocket> UdpSocket::join(const std::string& group, int port, const std::string& interface) {
  const std::string where = group + ":" + std::to_string(port);
  const auto at = udp_address(group, port);
  const auto over = udp_address(interface, 0);
  if (!at) return Failure(at.error());
  if (!over) return Failure(over.error());
  if ((ntohl(at->host) >> 28) != 0xE)
    return bad_input("is no multicast address", where, "For instance 239.255.42.99");
  auto fd = open_bound(*at, true, where);  // bound to the group: nothing else is received
  if (!fd) return Failure(fd.error());
  ip_mreq membership{};
  membership.imr_multiaddr.s_addr = at->host;
  membership.imr_interface.s_addr = over->host;
  if (::setsockopt(fd->get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0)
    return failure("cannot join the group over " + interface, where);
  return UdpSocket(std::move(*fd), port);
}

Status UdpSocket::send(std::span<const std::byte> datagram, const UdpAddress& to) const {
  const sockaddr_in address = socket_address(to);
  const ssize_t sent = ::sendto(fd_.get(), datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                                reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (sent == static_cast<ssize_t>(datagram.size())) return {};
  return failure("cannot send", "port " + std::to_string(to.port));
}

Result<std::span<const std::byte>> UdpSocket::receive(double timeout_s, UdpAddress* from) {
  pollfd waiting{fd_.get(), POLLIN, 0};
  const int milliseconds = static_cast<int>(std::ceil(1e3 * std::min(std::max(timeout_s, 0.0), 60.0)));
  const int ready = ::poll(&waiting, 1, milliseconds);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return std::span<const std::byte>();
  if (ready < 0) return failure("cannot wait", "port " + std::to_string(port_));
  sockaddr_in sender{};
  socklen_t size = sizeof sender;
  const ssize_t n = ::recvfrom(fd_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT,
                               reinterpret_cast<sockaddr*>(&sender), &size);
  // an answer that nobody wanted (ECONNREFUSED of an earlier send) ends nothing
  if (n < 0) return std::span<const std::byte>();
  if (from != nullptr) *from = {sender.sin_addr.s_addr, ntohs(sender.sin_port)};
  return std::span<const std::byte>(buffer_.data(), static_cast<std::size_t>(n));
}

}  // namespace omniflight::gateway
