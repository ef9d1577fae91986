// The host's line to one board: opens the device, finds out who is there, sends and receives messages.
// Nothing blocks; deadlines are in the caller's time.
#pragma once

#include <optional>

#include "omniflight_gateway/serial_port.hpp"
#include "omniflight_gateway/tk3_codec.hpp"
#include "omniflight_gateway/tk3_units.hpp"

namespace omniflight::gateway {

enum class BoardKind { unknown, chimera, teensy, mkfl, flymu, mkbl };
std::string_view to_string(BoardKind kind);
/// What a kind of board brings along.
bool has_imu(BoardKind kind);
bool has_motors(BoardKind kind);
ImuScale imu_scale(BoardKind kind);

/// Reads "chimera1.1", "teensy1.2", "mkfl1.8", ... and refuses names and versions nobody has tested.
Result<BoardKind> identify(std::string_view id);

struct LinkConfig {
  std::string device;
  unsigned baud = 115200;    ///< 0, 57600, 115200, 500000 or 2000000; USB boards ignore it
  double id_retry_s = 0.5;   ///< s between id queries
  unsigned id_attempts = 4;  ///< then the board counts as absent
  double silence_s = 0.4;    ///< s without any intact frame while streams run: the board is lost; 0 = never
  double write_stall_s = 0.25;  ///< s with output pending that the line does not take
};

class BoardLink {
 public:
  explicit BoardLink(LinkConfig config) : config_(std::move(config)) {}

  /// Opens the device and asks for the id; poll() brings the answer.
  Status open(double now_s);
  /// Writes what the line takes at once, then closes.
  void close();

  /// Reads, decodes, writes. Appends messages other than the id to `received`. An error (hang-up, silence,
  /// stalled line, wrong or missing board) closes the line and is kept: later calls return it until open().
  Status poll(double now_s, std::vector<BoardMessage>& received);

  /// Queues a message; the newest velocity command replaces one that has not begun to leave.
  Status send(const HostMessage& message);
  /// From now on silence is an error.
  void expect_traffic(double now_s);

  int fd() const { return fd_.get(); }
  bool is_open() const { return fd_.is_open(); }
  bool identified() const { return kind_ != BoardKind::unknown; }
  BoardKind kind() const { return kind_; }
  const std::string& id() const { return id_; }
  const LinkConfig& config() const { return config_; }
  const DecoderStatistics& decoder_statistics() const { return decoder_.statistics(); }
  /// Bytes since construction; with the emulator's counts a lockstep run sees that nothing is in flight.
  std::uint64_t bytes_read() const { return stream_.bytes_read(); }
  std::uint64_t bytes_written() const { return stream_.bytes_written(); }
  std::uint64_t refused_messages() const { return refused_messages_; }  ///< intact frames without a meaning
  std::uint64_t superseded_commands() const { return superseded_commands_; }

 private:
  Status serve(double now_s, std::vector<BoardMessage>& received);
  Status ask(double now_s);
  Status receive(std::vector<BoardMessage>& received, double now_s);
  Status transmit(double now_s);
  Failure failure(std::string message, std::string next) const;

  LinkConfig config_;
  FileDescriptor fd_;
  ByteStream stream_;
  FrameDecoder decoder_;
  std::vector<std::uint8_t> bytes_;
  std::optional<Wire> velocity_;  ///< newest command, not yet in the stream
  std::optional<Error> error_;
  BoardKind kind_ = BoardKind::unknown;
  std::string id_;
  unsigned asked_ = 0;
  double asked_s_ = 0.0, heard_s_ = 0.0, moved_s_ = 0.0;
  bool expects_traffic_ = false;
  std::uint64_t refused_messages_ = 0, superseded_commands_ = 0;
};

}  // namespace omniflight::gateway
