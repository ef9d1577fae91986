// The lab's avionics without hardware: two Teensy boards of four motors and one chimera board with the IMU,
// each speaking telekyb3 over its own pseudo terminal, flying a plant the caller gives.
#pragma once

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

struct EmulatorConfig {
  std::vector<EmulatedBoardConfig> boards;
  std::string link_directory;  ///< existing directory for symbolic links board0, board1, ...; empty: none

  /// Two Teensys (rotors 0-3 and 4-7) and a chimera with IMU and battery.
  static EmulatorConfig omnimorph();
};

/// Owns the pseudo terminals; borrows the plant. Not thread safe: one thread steps it.
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

  /// What the host opens for board i: the link when there is a directory, else the pty itself (changes on
  /// plug()).
  std::string device(std::size_t i) const;
  bool plugged(std::size_t i) const { return boards_[i].pty.master.is_open(); }
  /// Bytes over board i's line since construction.
  std::uint64_t bytes_read(std::size_t i) const { return boards_[i].stream.bytes_read(); }
  std::uint64_t bytes_written(std::size_t i) const { return boards_[i].stream.bytes_written(); }
  /// Pulls the cable: the host sees a hang-up. The board keeps its power and its watchdog.
  void unplug(std::size_t i);
  /// Puts it back on a new pseudo terminal.
  Status plug(std::size_t i);
  /// Puts bytes on board i's line to the host as they are, as a bad cable would. False when the line is full
  /// or cut.
  bool inject_noise(std::size_t i, std::span<const std::uint8_t> bytes);

  std::size_t board_count() const { return boards_.size(); }
  EmulatedBoard& board(std::size_t i) { return boards_[i].board; }
  const std::vector<double>& command() const { return command_; }
  std::uint64_t dropped_frames() const { return dropped_; }

 private:
  struct Connected {
    EmulatedBoard board;
    PseudoTerminal pty;
    ByteStream stream;
  };
  BoardEmulator(EmulatorConfig config, EmulatedPlant& plant);
  std::string link(std::size_t i) const;

  std::string link_directory_;
  EmulatedPlant* plant_;
  std::vector<Connected> boards_;
  std::vector<double> command_;
  std::vector<std::uint8_t> bytes_, answers_;
  std::uint64_t dropped_ = 0;
};

}  // namespace omniflight::gateway
