// The lab's avionics without hardware: two Teensy boards of four motors and one chimera board with the IMU,
// each speaking telekyb3 over its own line, flying a plant the caller gives.
#pragma once

#include <functional>

#include "omniflight_gateway/emulated_board.hpp"
#include "omniflight_gateway/serial_port.hpp"

namespace omniflight::gateway {

/// The physics behind the boards, by global rotor id.
class EmulatedPlant {
 public:
  virtual ~EmulatedPlant() = default;
  /// Rotor speeds [rad/s, signed] the boards drive from now on, after quantisation, ramps and watchdogs.
  virtual void set_command(std::span<const double> rotor_velocity_radps) = 0;
  /// What the sensors see now.
  virtual PlantSample sample() = 0;
};

/// What a host opens. Only a pseudo terminal takes the kernel's path of a serial device, and its latency:
/// none when the machine is idle, seconds when it is busy. A socket delivers at once.
enum class LineKind { pseudo_terminal, socket };

struct EmulatorConfig {
  std::vector<EmulatedBoardConfig> boards;
  /// Existing directory for board0, board1, ...: symbolic links to the pseudo terminals (empty: none), or the
  /// sockets themselves (required).
  std::string link_directory;
  LineKind line = LineKind::pseudo_terminal;
  /// Called with every piece of bytes that a board has received from the host, before it is decoded.
  std::function<void(std::size_t board, std::span<const std::uint8_t> bytes)> on_received;

  /// Two Teensys (rotors 0-3 and 4-7) and a chimera with IMU and battery.
  static EmulatorConfig omnimorph();
};

/// Owns the lines; borrows the plant. Not thread safe: one thread steps it.
class BoardEmulator {
 public:
  /// @param plant must outlive the emulator.
  static Result<BoardEmulator> create(EmulatorConfig config, EmulatedPlant& plant);
  ~BoardEmulator();
  BoardEmulator(BoardEmulator&&) = default;
  BoardEmulator& operator=(BoardEmulator&&) = delete;

  /// Reads the lines, moves the motors, hands the plant its command, samples it, writes what is due. Never
  /// blocks: frames that a full line does not take are dropped whole and counted.
  /// @param now_s time of the plant, s, not decreasing.
  Status step(double now_s);
  /// Only reads the lines, as step() does first; for lockstep runs that wait for bytes in flight.
  Status receive(double now_s);
  /// Waits for bytes from the host, at most timeout_s (up to 1 s).
  void wait(double timeout_s) const;

  /// What the host opens for board i: its name in the directory when there is one, else the pty itself
  /// (changes on plug()).
  std::string device(std::size_t i) const;
  bool plugged(std::size_t i) const { return boards_[i].plugged(); }
  /// Bytes over board i's line since construction.
  std::uint64_t bytes_read(std::size_t i) const { return boards_[i].stream.bytes_read(); }
  std::uint64_t bytes_written(std::size_t i) const { return boards_[i].stream.bytes_written(); }
  /// Pulls the cable: the host sees a hang-up. The board keeps its power and its watchdog.
  void unplug(std::size_t i);
  /// Puts it back on a new line.
  Status plug(std::size_t i);
  /// Puts bytes on board i's line to the host as they are, as a bad cable would. False when the line is full
  /// or cut.
  bool inject_noise(std::size_t i, std::span<const std::uint8_t> bytes);

  std::size_t board_count() const { return boards_.size(); }
  EmulatedBoard& board(std::size_t i) { return boards_[i].board; }
  /// Whether any motor of any board turns or starts.
  bool any_motor_on() const;
  const std::vector<double>& command() const { return command_; }
  std::uint64_t dropped_frames() const { return dropped_; }

 private:
  struct Connected {
    EmulatedBoard board;
    PseudoTerminal pty;             ///< one of these two is open
    FileDescriptor listener, host;  ///< host: while one is connected
    ByteStream stream;
    bool plugged() const { return pty.master.is_open() || listener.is_open(); }
    int line() const { return pty.master.is_open() ? pty.master.get() : host.get(); }  ///< -1: nobody there
    void meet_host();
    Status kept(Status moved);
  };
  BoardEmulator(EmulatorConfig config, EmulatedPlant& plant);
  std::string link(std::size_t i) const;

  std::string link_directory_;
  LineKind line_;
  std::function<void(std::size_t, std::span<const std::uint8_t>)> on_received_;
  EmulatedPlant* plant_;
  std::vector<Connected> boards_;
  std::vector<double> command_;
  std::vector<std::uint8_t> bytes_, answers_;
  std::uint64_t dropped_ = 0;
};

}  // namespace omniflight::gateway
