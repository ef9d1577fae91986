// All boards of a vehicle as one: connect, start the motors, send rotor speeds, collect telemetry.
#pragma once

#include <omniflight_core/result.hpp>
#include <optional>
#include <span>

#include "omniflight_gateway/board_link.hpp"
#include "omniflight_gateway/sequence_clock.hpp"
#include "omniflight_gateway/telemetry.hpp"

namespace omniflight::gateway {

struct BoardPort {
  std::string device;
  std::size_t rotors = 4;                     ///< motors, if it turns out to be a motor board
  std::optional<std::size_t> rotor_offset{};  ///< global id of its first; default: in the order of the list
};

struct GatewayConfig {
  std::vector<BoardPort> boards;
  std::size_t rotors = 8;     ///< the motor boards together must have exactly these
  LinkConfig link;            ///< its device is ignored
  double imu_rate_hz = 1000;  ///< 0 = off, at most 2000
  double magnetic_rate_hz = 0;
  double motor_rate_hz = 100;
  double battery_rate_hz = 1;
  double start_retry_s = 0.1;                 ///< s between repeated start commands
  double start_deadline_s = 5.0;              ///< s for all motors to spin
  double plausible_speed_radps = 3000;        ///< measured |speed| beyond is line noise
  double plausible_specific_force_step = 80;  ///< m/s^2 between neighbouring samples; beyond is line noise
};

/// Gains of a board's speed loop, in the board's own units: 0 to 6.5535 in steps of 0.0001.
struct BoardGains {
  double kp = 0.0, ki = 0.0, kd = 0.0, f = 0.0;
};
/// As the wire carries them; id from 1 on its board. Errors name the gain that it cannot carry: out of range,
/// or so small that it would become 0.
Result<PidGains> to_counts(const BoardGains& gains, std::uint8_t id);

enum class GatewayPhase { closed, identifying, connected, starting, running, failed };
std::string_view to_string(GatewayPhase phase);

struct GatewayStatistics {
  std::uint64_t frames = 0, refused_frames = 0, stray_bytes = 0, refused_messages = 0;
  std::uint64_t implausible = 0;  ///< intact messages whose values cannot be true (no checksum on this line)
  std::uint64_t duplicates = 0;
  std::uint64_t missed_imu = 0, missed_rotor = 0;
  std::uint64_t commands_sent = 0, commands_superseded = 0;
  std::uint64_t telemetry_dropped = 0;  ///< nobody fetched it in time
};

/// One thread drives it; nothing blocks longer than the timeout given to poll().
class Gateway {
 public:
  static Result<Gateway> create(GatewayConfig config);

  /// Opens all devices (after a failure: again) and begins to identify them; poll() until connected().
  Status connect(double now_s);
  void close();

  /// Waits for input, at most timeout_s of real time (0 to 1), then reads, decodes and writes. Samples are
  /// stamped with now_s, so a caller in real time gives timeout 0 here and waits in wait(). After a lost
  /// board every call returns that board's error until connect(); the other boards stay served, so that a
  /// safety gate can still wind them down.
  Status poll(double now_s, double timeout_s = 0.0);
  void wait(double timeout_s) const;

  /// Starts all motors: repeated until all spin or start_deadline_s has passed. Needs phase connected.
  Status start_motors(double now_s);
  /// Stops all motors now.
  Status stop_motors();
  /// Sends rotor speeds [rad/s, signed, by global id]; slower than 15.259 Hz means stop. Needs phase running,
  /// or failed, where the boards that are left get it and the error is returned.
  Status send_velocities(std::span<const double> speeds_radps);

  /// Sends the gains of one rotor's speed loop, by global id. Needs a connected gateway.
  Status send_gains(std::size_t rotor, const BoardGains& gains);

  /// Moves out what has been received since the last call.
  void fetch(Telemetry& telemetry);

  GatewayPhase phase() const { return phase_; }
  bool connected() const { return phase_ >= GatewayPhase::connected && phase_ != GatewayPhase::failed; }
  /// How many rotors last reported that they spin.
  std::size_t spinning_rotors() const;
  /// A motor reports an emergency, in two frames running (cleared by connect()).
  bool emergency() const { return emergency_; }
  const std::optional<Error>& error() const { return error_; }
  GatewayStatistics statistics() const;
  const BoardLink& link(std::size_t i) const { return boards_[i].link; }
  /// Global id of the first rotor of board i; meaningful when connected and it is a motor board.
  std::size_t rotor_offset(std::size_t i) const { return boards_[i].offset; }

 private:
  struct Board {
    BoardLink link;
    BoardPort port;
    std::size_t offset = 0;
    std::size_t motors = 0;  ///< 0 until identified as a motor board
    SequenceClock imu_clock, magnetic_clock;
  };
  struct Rotor {
    SequenceClock clock;
    bool spinning = false, starting = false;
    unsigned emergency_frames = 0;
  };

  explicit Gateway(GatewayConfig config);
  Status assign_roles(double now_s);
  Status begin_streams(double now_s);
  Status keep_starting(double now_s);
  void fail_with(const Error& error);
  void take(Board& board, const BoardMessage& message, double now_s);
  void take_imu(Board& board, const ImuData& m, double now_s);
  void take_motor(Board& board, const MotorData& m, double now_s);
  bool plausible(const Vec3& specific_force);
  template <class Sample>
  void store(std::vector<Sample>& list, Sample sample);

  GatewayConfig config_;
  std::vector<Board> boards_;
  std::vector<Rotor> rotors_;
  std::vector<BoardMessage> received_;
  Telemetry telemetry_;
  GatewayPhase phase_ = GatewayPhase::closed;
  std::optional<Error> error_;
  bool emergency_ = false;
  double start_begun_s_ = 0.0, start_sent_s_ = 0.0;
  std::optional<Vec3> last_force_;
  unsigned implausible_in_a_row_ = 0;
  std::uint64_t implausible_ = 0, duplicates_ = 0, commands_ = 0, dropped_ = 0;
};

}  // namespace omniflight::gateway
