#include "omniflight_gateway/serial_port.hpp"

#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <optional>

#include "omniflight_gateway/local_socket.hpp"

namespace omniflight::gateway {
namespace {

Failure system_failure(const std::string& what, const std::string& where, const std::string& next) {
  return bad_input(what + ": " + std::strerror(errno), where, next);
}

std::optional<speed_t> termios_speed(unsigned baud) {
  switch (baud) {
    case 57600:
      return B57600;
    case 115200:
      return B115200;
    case 500000:
      return B500000;
    case 2000000:
      return B2000000;
    default:
      return std::nullopt;
  }
}

bool make_raw(int fd, std::optional<speed_t> speed) {
  termios t{};
  if (tcgetattr(fd, &t) != 0) return false;
  t.c_iflag = IGNBRK;
  t.c_oflag = 0;
  t.c_lflag = 0;
  t.c_cflag =
      (t.c_cflag & static_cast<tcflag_t>(~(CSIZE | PARENB | CSTOPB | CRTSCTS))) | CS8 | CREAD | CLOCAL;
  t.c_cc[VMIN] = 1;  // with O_NONBLOCK: no data is EAGAIN, so that 0 can only mean hang-up
  t.c_cc[VTIME] = 0;
  if (speed && (cfsetospeed(&t, *speed) != 0 || cfsetispeed(&t, *speed) != 0)) return false;
  return tcsetattr(fd, TCSANOW, &t) == 0;
}

/// Drivers that know no latency (ptys, USB serial without 16550 heritage) refuse; that is no reason to give
/// up.
void ask_for_low_latency(int fd) {
  serial_struct s{};
  if (ioctl(fd, TIOCGSERIAL, &s) != 0 || (s.flags & ASYNC_LOW_LATENCY) != 0) return;
  s.flags |= ASYNC_LOW_LATENCY;
  (void)ioctl(fd, TIOCSSERIAL, &s);
}

bool is_socket(int fd) {
  struct stat s {};
  return fstat(fd, &s) == 0 && S_ISSOCK(s.st_mode);
}

/// How many of `most` bytes can be read from a tty without waiting. Even a non-blocking read of an empty tty
/// waits, uninterruptibly, until a kernel worker has handed over what is on its way (n_tty_read flushes the
/// port's work), and that worker has no priority over anybody: beside busy programs it took more than 3 s. So
/// an empty tty is never read. One that is hung up cannot tell, and its read does not wait.
std::size_t readable(int tty, std::size_t most) {
  int waiting = 0;
  if (ioctl(tty, FIONREAD, &waiting) != 0) return most;
  return std::min(most, static_cast<std::size_t>(std::max(waiting, 0)));
}

/// A peer that is gone is an error of this call, not a signal to this process.
ssize_t put(int fd, const std::uint8_t* bytes, std::size_t count) {
  const ssize_t n = ::send(fd, bytes, count, MSG_NOSIGNAL | MSG_DONTWAIT);
  return n < 0 && errno == ENOTSOCK ? ::write(fd, bytes, count) : n;
}

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

void FileDescriptor::reset() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

Result<FileDescriptor> open_serial(const std::string& device, unsigned baud) {
  const auto speed = termios_speed(baud);
  if (baud != 0 && !speed) {
    return bad_input("baud rate " + std::to_string(baud) + " is not supported", device,
                     "Use 0, 57600, 115200, 500000 or 2000000");
  }
  if (is_local_socket(device)) return connect_local(device);
  FileDescriptor fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd.is_open()) {
    return system_failure("cannot open the board's device", device,
                          "Check that the board is plugged in and that you may read and write its device");
  }
  if (isatty(fd.get()) == 0) {
    return bad_input("is not a serial device", device, "Give a tty or pty, for instance /dev/ttyACM0");
  }
  if (!make_raw(fd.get(), speed)) {
    return system_failure("cannot set the line to raw", device, "Check the baud rate and the driver");
  }
  ask_for_low_latency(fd.get());
  tcflush(fd.get(), TCIOFLUSH);
  return fd;
}

Result<PseudoTerminal> open_pseudo_terminal() {
  const std::string next = "Check that /dev/ptmx and /dev/pts are there";
  PseudoTerminal pty;
  pty.master = FileDescriptor(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!pty.master.is_open()) return system_failure("cannot open a pseudo terminal", "/dev/ptmx", next);
  std::array<char, 64> name{};
  if (grantpt(pty.master.get()) != 0 || unlockpt(pty.master.get()) != 0 ||
      ptsname_r(pty.master.get(), name.data(), name.size()) != 0) {
    return system_failure("cannot unlock a pseudo terminal", "/dev/ptmx", next);
  }
  pty.path = name.data();
  pty.slave = FileDescriptor(::open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!pty.slave.is_open() || !make_raw(pty.slave.get(), std::nullopt)) {
    return system_failure("cannot set up a pseudo terminal", pty.path, next);
  }
  return pty;
}

Status ByteStream::read(int fd, std::vector<std::uint8_t>& in, std::size_t limit) {
  std::array<std::uint8_t, 1024> chunk;
  const bool socket = is_socket(fd);
  while (limit > 0) {
    std::size_t most = std::min(limit, chunk.size());
    if (!socket) most = readable(fd, most);
    if (most == 0) return {};
    const ssize_t n = ::read(fd, chunk.data(), most);
    if (n < 0) {
      if (would_block()) return {};
      return system_failure("the line is broken", "serial read", "Check the cable, then connect again");
    }
    if (n == 0) return bad_input("the device hung up", "serial read", "Check the cable, then connect again");
    in.insert(in.end(), chunk.begin(), chunk.begin() + n);
    limit -= static_cast<std::size_t>(n);
    bytes_read_ += static_cast<std::uint64_t>(n);
  }
  return {};
}

bool ByteStream::queue(std::span<const std::uint8_t> bytes) {
  if (pending() + bytes.size() > output_limit_) return false;
  if (sent_ == output_.size()) clear();
  output_.insert(output_.end(), bytes.begin(), bytes.end());
  return true;
}

Status ByteStream::flush(int fd) {
  while (pending() > 0) {
    const ssize_t n = put(fd, output_.data() + sent_, pending());
    if (n < 0) {
      if (would_block()) return {};
      return system_failure("the line is broken", "serial write", "Check the cable, then connect again");
    }
    if (n == 0) return {};
    sent_ += static_cast<std::size_t>(n);
    bytes_written_ += static_cast<std::uint64_t>(n);
  }
  clear();
  return {};
}

void ByteStream::clear() {
  output_.clear();
  sent_ = 0;
}

void wait_readable(std::span<const int> fds, double timeout_s) {
  std::array<pollfd, 16> polled{};
  const std::size_t count = std::min(fds.size(), polled.size());
  for (std::size_t i = 0; i < count; ++i) polled[i] = {fds[i], POLLIN, 0};
  const double bounded = timeout_s > 0 ? std::min(timeout_s, 1.0) : 0.0;  // NaN waits not at all
  const auto whole = static_cast<time_t>(bounded);
  const timespec timeout{whole, static_cast<long>((bounded - static_cast<double>(whole)) * 1e9)};
  (void)ppoll(polled.data(), static_cast<nfds_t>(count), &timeout, nullptr);
}

}  // namespace omniflight::gateway
