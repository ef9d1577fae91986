// UDP datagrams, sent and received, also by multicast, on one interface.
#pragma once

#include <cstdint>
#include <omniflight_core/result.hpp>
#include <span>
#include <string>
#include <vector>

#include "omniflight_gateway/serial_port.hpp"

namespace omniflight::gateway {

struct UdpAddress {
  std::uint32_t host = 0;  ///< network byte order
  std::uint16_t port = 0;  ///< host byte order
};
/// "239.255.42.99" and a port; names are not resolved.
Result<UdpAddress> udp_address(const std::string& host, int port);

class UdpSocket {
 public:
  /// Receives what arrives at a port (0: any free one) of the interface with this address.
  static Result<UdpSocket> bind(const std::string& interface, int port);
  /// Receives what is sent to a multicast group and port over the interface with this address; several may.
  static Result<UdpSocket> join(const std::string& group, int port, const std::string& interface);

  Status send(std::span<const std::byte> datagram, const UdpAddress& to) const;
  /// The next datagram, or an empty span after the timeout [s]. What is longer than 65507 bytes does not
  /// exist. from: who sent it.
  Result<std::span<const std::byte>> receive(double timeout_s, UdpAddress* from = nullptr);
  int port() const { return port_; }

 private:
  explicit UdpSocket(FileDescriptor fd, int port) : fd_(std::move(fd)), port_(port), buffer_(65536) {}
  FileDescriptor fd_;
  int port_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace omniflight::gateway
