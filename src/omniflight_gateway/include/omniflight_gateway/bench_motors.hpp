// Motors on a bench without hardware: what emulated boards drive when nothing flies.
#pragma once

#include <deque>

#include "omniflight_core/random.hpp"
#include "omniflight_gateway/board_emulator.hpp"

namespace omniflight::gateway {

struct BenchMotorConfig {
  std::size_t rotors = 4;
  double lag_up_s = 0.034;    ///< s, first-order lag of a speed that rises
  double lag_down_s = 0.050;  ///< s, of one that falls
  double delay_s = 0.006;     ///< s, from command to motor
  double noise_radps = 2.0;   ///< rms of the measured speed, white
  double battery_V = 15.2;    ///< at the start
  double sag_V_per_s = 0.004;
  std::uint64_t seed = 1;
};

class BenchMotors : public EmulatedPlant {
 public:
  explicit BenchMotors(const BenchMotorConfig& config);
  void set_command(std::span<const double> rotor_velocity_radps) override;
  PlantSample sample() override;
  /// Moves the motors up to now_s, exactly: commands are held between calls.
  void step(double now_s);

 private:
  struct Command {
    double since_s;
    std::vector<double> speeds;
  };
  BenchMotorConfig config_;
  Random random_;
  std::deque<Command> commands_;  ///< the one that acts first, then those on their way
  std::vector<double> speeds_;
  double now_s_ = 0.0, started_s_ = 0.0;
  bool stepped_ = false;
};

}  // namespace omniflight::gateway
