// A bench without hardware: emulated boards drive motors of known lag, the record has what they did.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "omniflight_gateway/bench_motors.hpp"
#include "omniflight_gateway/motor_bench.hpp"

namespace omniflight::gateway {
namespace {

struct Rig {
  explicit Rig(const BenchMotorConfig& config)
      : motors(config), folder(make_folder()), emulator(make(motors, folder)) {
    clock.now = [this] { return now_s; };
    clock.advance = [this](double until_s) -> Status {
      now_s = until_s;
      motors.step(now_s);
      const Status ok = emulator.step(now_s);
      motors.take_gains(emulator);
      return ok;
    };
  }
  ~Rig() { std::filesystem::remove_all(folder); }
  static std::string make_folder() {
    char name[] = "/tmp/omniflight_bench_XXXXXX";
    return mkdtemp(name);
  }
  static BoardEmulator make(BenchMotors& motors, const std::string& folder) {
    EmulatorConfig config;
    config.boards = {EmulatedBoardConfig{}};
    config.link_directory = folder;
    config.line = LineKind::socket;
    return *BoardEmulator::create(std::move(config), motors);
  }
  Gateway gateway() {
    GatewayConfig config;
    config.boards = {{emulator.device(0)}};
    config.rotors = 4;
    config.imu_rate_hz = 0;
    config.motor_rate_hz = 500;
    config.battery_rate_hz = 10;
    return *Gateway::create(config);
  }

  double now_s = 10.0;
  BenchMotors motors;
  std::string folder;
  BoardEmulator emulator;
  BenchClock clock;
};

TEST(MotorBench, AStepComesBackWithTheMotorsLagAndDelay) {
  Rig rig({.lag_up_s = 0.04, .lag_down_s = 0.08, .delay_s = 0.01, .noise_radps = 0});
  std::vector<double> command(300, 600.0);
  std::fill(command.begin() + 100, command.begin() + 200, 800.0);
  auto gateway = rig.gateway();
  const auto record = run_motor_bench(gateway, 4, command, {.max_speed_radps = 1000}, rig.clock);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_TRUE(record->complete);
  EXPECT_EQ(record->refused, 0u);
  EXPECT_EQ(record->missed, 0u);
  EXPECT_EQ(record->command_s.size(), 300u);
  EXPECT_NEAR(record->command_s.back(), 2.99, 1e-6);
  EXPECT_GT(record->battery.size(), 20u);
  // up at 1 s: 63 % after delay, lag and the way over the line; down at 2 s with the other lag
  const auto reached = [&](double from_s, double level, bool up) {
    for (const RotorSample& s : record->rotors)
      if (s.rotor == 2 && s.time_s > from_s && (up ? s.speed_radps >= level : s.speed_radps <= level))
        return s.time_s - from_s;
    return std::nan("");
  };
  EXPECT_NEAR(reached(1.0, 600 + 200 * 0.632, true), 0.05, 0.006);
  EXPECT_NEAR(reached(2.0, 800 - 200 * 0.632, false), 0.09, 0.006);
  EXPECT_FALSE(rig.emulator.any_motor_on());
}

TEST(MotorBench, RefusesACommandBeyondTheLimitBeforeAnyMotorTurns) {
  Rig rig({});
  auto gateway = rig.gateway();
  const auto record =
      run_motor_bench(gateway, 4, std::vector<double>{500, 1200}, {.max_speed_radps = 1000}, rig.clock);
  ASSERT_FALSE(record);
  EXPECT_NE(record.error().text().find("1200"), std::string::npos) << record.error().text();
  EXPECT_FALSE(rig.emulator.any_motor_on());
}

TEST(MotorBench, StopsTheMotorsWhenItIsToldTo) {
  Rig rig({});
  const double begin = rig.now_s;
  rig.clock.stop = [&] { return rig.now_s > begin + 3.0; };
  auto gateway = rig.gateway();
  const auto record =
      run_motor_bench(gateway, 4, std::vector<double>(2000, 500.0), {.max_speed_radps = 1000}, rig.clock);
  ASSERT_TRUE(record) << record.error().text();
  EXPECT_FALSE(record->complete);
  EXPECT_LT(record->command_s.size(), 400u);
  EXPECT_FALSE(rig.emulator.any_motor_on());
}

TEST(MotorBench, ALostBoardEndsTheRunWithItsName) {
  Rig rig({});
  const auto advance = rig.clock.advance;
  rig.clock.advance = [&, advance](double until_s) {
    if (rig.now_s > 13.0 && rig.emulator.plugged(0)) rig.emulator.unplug(0);
    return advance(until_s);
  };
  auto gateway = rig.gateway();
  const auto record =
      run_motor_bench(gateway, 4, std::vector<double>(2000, 500.0), {.max_speed_radps = 1000}, rig.clock);
  ASSERT_FALSE(record);
  EXPECT_NE(record.error().text().find("board0"), std::string::npos) << record.error().text();
}

/// Mean |command - speed| [rad/s] of rotor 1 after every command.
double error_of(const BenchRecord& record, double period_s) {
  double sum = 0, count = 0;
  for (const RotorSample& s : record.rotors) {
    const auto at = static_cast<std::size_t>(std::max(0.0, s.time_s) / period_s);
    if (s.rotor != 0 || at >= record.command_radps.size()) continue;
    sum += std::abs(record.command_radps[at] - s.speed_radps);
    count += 1;
  }
  return sum / count;
}

TEST(MotorBench, GainsReachTheBoardsAreReadBackAndChangeTheLoop) {
  std::vector<double> command(600, 600.0);
  for (std::size_t k = 0; k < command.size(); ++k)
    if (k / 60 % 2 == 1) command[k] = 700;
  double errors[2] = {};
  const BoardGains gains[2] = {{0.0005, 0.02, 0, 0}, {0.005, 0.15, 0, 0}};
  for (int run = 0; run < 2; ++run) {
    Rig rig({.noise_radps = 1, .speed_loop = true});
    auto gateway = rig.gateway();
    const auto record =
        run_motor_bench(gateway, 4, command, {.max_speed_radps = 1000, .gains = gains[run]}, rig.clock);
    ASSERT_TRUE(record) << record.error().text();
    EXPECT_EQ(record->gains_confirmed, 4u);
    EXPECT_EQ(rig.emulator.board(0).gains(3)->kp, run == 0 ? 5 : 50);
    // in the end speed is as commanded, and the throttle what holds it
    EXPECT_NEAR(record->rotors.back().throttle, record->rotors.back().speed_radps / 1900, 0.1);
    errors[run] = error_of(*record, 0.01);
  }
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

TEST(MotorBench, GainsThatTheWireCannotCarryAreRefusedBeforeAnyMotorTurns) {
  for (const BoardGains& gains :
       {BoardGains{7, 0, 0, 0}, {0.00001, 0, 0, 0}, {-1, 0, 0, 0}, {0, std::nan(""), 0, 0}}) {
    Rig rig({});
    auto gateway = rig.gateway();
    const auto record = run_motor_bench(gateway, 4, std::vector<double>(10, 500.0),
                                        {.max_speed_radps = 1000, .gains = gains}, rig.clock);
    ASSERT_FALSE(record);
    EXPECT_NE(record.error().text().find("0.0001 to 6.5535"), std::string::npos) << record.error().text();
    EXPECT_FALSE(rig.emulator.any_motor_on());
  }
}

}  // namespace
}  // namespace omniflight::gateway
