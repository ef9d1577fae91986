// One telekyb3 board without hardware: bytes in, bytes out, time passed in. What it flies is the caller's
// plant.
#pragma once

#include <omniflight_core/frames.hpp>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_gateway/tk3_codec.hpp"
#include "omniflight_gateway/tk3_units.hpp"

namespace omniflight::gateway {

/// What the plant's sensors see at one instant.
struct PlantSample {
  Vec3 specific_force_B = Vec3(0, 0, kGravity);  ///< m/s^2, body axes, +9.81 z at rest
  Vec3 w_WB_B = Vec3::Zero();                    ///< rad/s
  std::vector<double> rotor_speed_radps;         ///< signed, by global rotor id; missing ones read as 0
  std::vector<double> rotor_current_A;           ///< by global rotor id; missing ones read as 0
  /// Share of full throttle by global rotor id; missing ones read as commanded over full speed.
  std::vector<double> rotor_throttle = {};
  double battery_V = 0.0;
};

struct EmulatedBoardConfig {
  std::string id = "teensy1.2";  ///< answered to '?': name and version
  std::size_t rotor_offset = 0;  ///< global id of its first rotor, 0-based
  std::size_t rotors = 4;        ///< 0 to 15
  ImuScale imu_scale;            ///< of its IMU frames
  bool has_imu = false;
  bool has_battery = true;
  double start_time_s = 0.2;          ///< s, from 'g' to spinning
  double watchdog_s = 0.5;            ///< s without a velocity or throttle command until it ramps down
  double ramp_down_s = 0.5;           ///< s, then the motors stop and need 'g' again
  double full_throttle_radps = 1900;  ///< rad/s at 100 % throttle
};

class EmulatedBoard {
 public:
  explicit EmulatedBoard(EmulatedBoardConfig config) : config_(std::move(config)), motors_(config_.rotors) {}

  /// Takes bytes as they come from the line; answers (id, texts) are appended to `out`.
  void receive(std::span<const std::uint8_t> bytes, double now_s, std::vector<std::uint8_t>& out);
  /// Motor states and watchdog up to now_s; then target() is what the board drives.
  void update(double now_s);
  /// Appends the frames that are due. A stream that fell more than a period behind skips, it never bursts.
  void emit(double now_s, const PlantSample& sample, std::vector<std::uint8_t>& out);

  /// Rotor speed [rad/s, signed] motor k (0-based on this board) is driven to; 0 when not spinning.
  double target(std::size_t k) const;
  /// Speed loop gains that motor k was last sent; nothing before the first.
  const std::optional<PidGains>& gains(std::size_t k) const { return motors_[k].gains; }
  /// Makes motor k report an emergency and stop, as the boards do on a lost commutation.
  void fail_motor(std::size_t k);

  const EmulatedBoardConfig& config() const { return config_; }
  bool spinning(std::size_t k) const { return motors_[k].state == MotorState::spinning; }
  /// A motor turns or starts.
  bool any_motor_on() const;
  std::uint64_t velocity_commands() const { return velocity_commands_; }
  std::uint64_t refused_messages() const { return refused_messages_; }
  const DecoderStatistics& decoder_statistics() const { return decoder_.statistics(); }

 private:
  enum class MotorState { stopped, starting, spinning, emergency };
  struct Motor {
    MotorState state = MotorState::stopped;
    double started_s = 0.0;
    double target_radps = 0.0;
    std::uint8_t seq = 0;
    std::optional<PidGains> gains{};
  };
  struct Stream {
    double period_s = 0.0;  ///< 0 = off
    double due_s = 0.0;
    std::uint8_t seq = 0;
  };

  void handle(const HostMessage& message, double now_s, std::vector<std::uint8_t>& out);
  void drive(const Counts& counts, double now_s,
             double (*to_speed)(std::int16_t, const EmulatedBoardConfig&));
  static bool due(Stream& stream, double now_s);
  double ramp() const;

  EmulatedBoardConfig config_;
  std::vector<Motor> motors_;
  FrameDecoder decoder_;
  Stream imu_, motor_, battery_;
  double now_s_ = 0.0;
  double commanded_s_ = 0.0;  ///< time of the newest command
  bool commanded_ = false;    ///< a command came since the motors started
  std::uint64_t velocity_commands_ = 0, refused_messages_ = 0;
};

}  // namespace omniflight::gateway
