// Motors on a bench without hardware: what emulated boards drive when nothing flies.
#pragma once

#include <deque>

#include "omniflight_core/random.hpp"
#include "omniflight_gateway/board_emulator.hpp"
#include "omniflight_gateway/gateway.hpp"

namespace omniflight::gateway {

struct BenchMotorConfig {
  std::size_t rotors = 4;
  double lag_up_s = 0.034;    ///< s, first-order lag of a speed that rises
  double lag_down_s = 0.050;  ///< s, of one that falls
  double delay_s = 0.006;     ///< s, from command to motor
  double noise_radps = 2.0;   ///< rms of the measured speed, white
  double battery_V = 15.2;    ///< at the start
  double sag_V_per_s = 0.004;
  /// true: boards close a speed loop around motors that follow a throttle; false: the motor is the loop's
  /// answer.
  bool speed_loop = false;
  double full_speed_radps = 1900;       ///< rad/s at full throttle
  double loop_period_s = 0.001;         ///< s, of the speed loop
  BoardGains gains{0.001, 0.02, 0, 0};  ///< of the loop until others are sent
  std::uint64_t seed = 1;
};

/// The speed loop of an emulated board: throttle = kp e + ki int(e) + kd de/dt through a low pass of 1000 f
/// [1/s], e in revolutions a second. What units and meaning of f real boards have is not known here.
class BenchMotors : public EmulatedPlant {
 public:
  explicit BenchMotors(const BenchMotorConfig& config);
  void set_command(std::span<const double> rotor_velocity_radps) override;
  PlantSample sample() override;
  /// Moves the motors up to now_s, exactly: commands are held between calls.
  void step(double now_s);
  /// Takes over what the boards of an emulator were sent.
  void take_gains(BoardEmulator& emulator);

 private:
  struct Command {
    double since_s;
    std::vector<double> speeds;
  };
  struct Loop {
    BoardGains gains;
    double integral = 0.0, filtered = 0.0, before = 0.0, throttle = 0.0;
  };
  void close_loops();
  double measured(std::size_t k);

  BenchMotorConfig config_;
  Random random_;
  std::vector<double> targets_;
  std::vector<Loop> loops_;
  double loop_due_s_ = 0.0;
  std::deque<Command> commands_;  ///< the one that acts first, then those on their way
  std::vector<double> speeds_;
  double now_s_ = 0.0, started_s_ = 0.0;
  bool stepped_ = false;
};

}  // namespace omniflight::gateway
