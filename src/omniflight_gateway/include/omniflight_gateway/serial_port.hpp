// Non-blocking bytes over a tty, pty or Unix stream socket. Every call returns at once, however busy the
// machine is; only wait_readable() waits.
#pragma once

#include <omniflight_core/result.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "omniflight_gateway/tk3_frame.hpp"

namespace omniflight::gateway {

/// Owns one file descriptor.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() { reset(); }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int get() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }
  void reset();

 private:
  int fd_ = -1;
};

/// Opens a device raw, 8N1, non-blocking, without becoming its session's terminal, and drops what it had
/// buffered. A path of a Unix stream socket is connected to instead (local_socket.hpp), whatever the baud.
/// @param baud 0 (leave as it is), 57600, 115200, 500000 or 2000000.
/// Asks for low latency where the driver knows it (a pty or USB device that does not is fine).
Result<FileDescriptor> open_serial(const std::string& device, unsigned baud);

/// Both ends of a raw pseudo terminal; `path` is what the other side opens. The own slave descriptor keeps
/// the line up while nobody has it open, as a board stays powered when its host goes.
struct PseudoTerminal {
  FileDescriptor master;
  FileDescriptor slave;
  std::string path;
};
Result<PseudoTerminal> open_pseudo_terminal();

/// Buffered byte stream over a descriptor that it does not own.
class ByteStream {
 public:
  explicit ByteStream(std::size_t output_limit = 4096) : output_limit_(output_limit) {}

  /// Appends what can be read now to `in` (at most `limit` bytes). An error means hang-up or a broken device.
  Status read(int fd, std::vector<std::uint8_t>& in, std::size_t limit = 16384);
  /// Queues whole frames; false, and nothing queued, when the line is too far behind.
  bool queue(std::span<const std::uint8_t> bytes);
  /// Writes what the line takes now.
  Status flush(int fd);
  std::size_t pending() const { return output_.size() - sent_; }
  void clear();
  /// Bytes moved since construction.
  std::uint64_t bytes_read() const { return bytes_read_; }
  std::uint64_t bytes_written() const { return bytes_written_; }

 private:
  std::size_t output_limit_;
  std::vector<std::uint8_t> output_;
  std::size_t sent_ = 0;
  std::uint64_t bytes_read_ = 0, bytes_written_ = 0;
};

/// Waits until a descriptor is readable or timeout_s (0 to 1 s) has passed; -1 entries are skipped. On a tty
/// the kernel may overrun the timeout while its worker has no processor: a control loop sleeps and reads
/// instead.
void wait_readable(std::span<const int> fds, double timeout_s);

}  // namespace omniflight::gateway
