// Gateway and emulated boards over real pseudo terminals: the good days.
#include "pty_flight.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

namespace omniflight::gateway {
namespace {

constexpr double kTwoPi = 2 * kPi;

TEST(Gateway, FindsOutWhoIsWhoAndStartsTheMotors) {
  PtyFlight f;
  ASSERT_TRUE(f.connect());
  EXPECT_EQ(f.gateway.link(0).id(), "teensy1.2");
  EXPECT_EQ(f.gateway.link(0).kind(), BoardKind::teensy);
  EXPECT_EQ(f.gateway.link(2).kind(), BoardKind::chimera);
  EXPECT_EQ(f.gateway.rotor_offset(1), 4u);
  EXPECT_FALSE(f.gateway.send_velocities(std::vector<double>(8, 100.0)));  // not started
  EXPECT_EQ(f.gateway.spinning_rotors(), 0u);
  ASSERT_TRUE(f.start());
  EXPECT_EQ(f.gateway.spinning_rotors(), 8u);
}

TEST(Gateway, VelocitiesReachThePlantQuantisedToHalfPeriods) {
  PtyFlight f;
  ASSERT_TRUE(f.connect() && f.start());
  const std::vector<double> hertz = {120, -120, 60, 180, 240, 300, 10, -60};
  const std::vector<double> flown = {120.019, -120.019, 60.0024, 180.050, 240.038, 300.120, 0, -60.0024};
  std::vector<double> speeds(8);
  std::transform(hertz.begin(), hertz.end(), speeds.begin(), [](double h) { return kTwoPi * h; });
  f.seen.clear();
  ASSERT_TRUE(f.hold(speeds, 0.2));
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_NEAR(f.plant.now.rotor_speed_radps[k] / kTwoPi, flown[k], 1e-3) << "rotor " << k;
  }
  // And back: the newest telemetry of each rotor, by its global id.
  std::vector<double> measured(8, std::nan(""));
  for (const auto& s : f.seen.rotors) {
    measured[s.rotor] = s.speed_radps / kTwoPi;
    if (s.rotor == 0) {
      EXPECT_DOUBLE_EQ(s.current_A, 1.5);
    }
    if (s.rotor == 7) {
      EXPECT_DOUBLE_EQ(s.current_A, 2.25);
    }
  }
  for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(measured[k], flown[k], 1e-3) << "rotor " << k;
}

TEST(Gateway, TelemetryComesBackInSiUnitsAtItsRates) {
  PtyFlight f;
  f.plant.now.specific_force_B = {1.0, -2.0, 9.81};
  f.plant.now.w_WB_B = {0.5, -0.25, 0.1};
  ASSERT_TRUE(f.connect());
  f.seen.clear();
  ASSERT_TRUE(f.until([] { return false; }, 1.5));
  ASSERT_GT(f.seen.imu.size(), 1400u);
  EXPECT_LT(f.seen.imu.size(), 1520u);
  EXPECT_NEAR(static_cast<double>(f.seen.rotors.size()), 8 * 150, 40);
  ASSERT_GE(f.seen.battery.size(), 1u);
  EXPECT_DOUBLE_EQ(f.seen.battery.back().voltage_V, 14.8);
  for (const auto& s : f.seen.imu) {
    EXPECT_LT((s.specific_force_B - Vec3(1.0, -2.0, 9.81)).cwiseAbs().maxCoeff(),
              0.5 * 8 * 9.81 / 32768 + 1e-9);
    EXPECT_LT((s.w_WB_B - Vec3(0.5, -0.25, 0.1)).cwiseAbs().maxCoeff(),
              0.5 * to_radians(1000) / 32768 + 1e-9);
    EXPECT_LE(s.time_s, s.arrival_s + 1e-9);
  }
  EXPECT_EQ(f.gateway.statistics().missed_imu, 0u);
  EXPECT_EQ(f.gateway.statistics().refused_frames, 0u);
}

TEST(Gateway, BoardsRampDownAndStopByThemselvesWhenCommandsCease) {
  PtyFlight f;
  ASSERT_TRUE(f.connect() && f.start());
  ASSERT_TRUE(f.hold(std::vector<double>(8, kTwoPi * 100), 0.1));
  const double full = f.plant.now.rotor_speed_radps[3];
  ASSERT_GT(full, 600);
  ASSERT_TRUE(f.until([&] { return f.plant.now.rotor_speed_radps[3] < full; }, 0.6));
  ASSERT_TRUE(f.until([&] { return f.plant.now.rotor_speed_radps[3] < full / 2; }, 0.3));
  ASSERT_TRUE(f.until([&] { return f.gateway.spinning_rotors() == 0; }, 0.5));
  EXPECT_EQ(f.plant.now.rotor_speed_radps[3], 0.0);
}

TEST(Gateway, StopStopsAtOnceAndMotorsCanStartAgain) {
  PtyFlight f;
  ASSERT_TRUE(f.connect() && f.start());
  ASSERT_TRUE(f.hold(std::vector<double>(8, 600), 0.05));
  ASSERT_TRUE(f.gateway.send_velocities(std::vector<double>(8, 700)));  // must not leave after the stop
  ASSERT_TRUE(f.gateway.stop_motors());
  ASSERT_TRUE(f.until([&] { return f.gateway.spinning_rotors() == 0; }, 0.2));
  EXPECT_EQ(f.emulator.command(), std::vector<double>(8, 0.0));
  EXPECT_TRUE(f.start());
}

TEST(Gateway, AMotorEmergencyIsSeen) {
  PtyFlight f;
  ASSERT_TRUE(f.connect() && f.start());
  EXPECT_FALSE(f.gateway.emergency());
  f.emulator.board(1).fail_motor(2);
  ASSERT_TRUE(f.until([&] { return f.gateway.emergency(); }, 0.2));
  EXPECT_TRUE(f.gateway.emergency());
  const auto hit =
      std::find_if(f.seen.rotors.begin(), f.seen.rotors.end(), [](const auto& s) { return s.emergency; });
  ASSERT_NE(hit, f.seen.rotors.end());
  EXPECT_EQ(hit->rotor, 6u);
}

TEST(Gateway, ExplicitOffsetsFollowTheWiringInsteadOfTheOrder) {
  EmulatorConfig boards = EmulatorConfig::omnimorph();
  std::swap(boards.boards[0], boards.boards[1]);  // the first device now drives rotors 4-7
  PtyFlight f(boards);
  GatewayConfig config;
  config.boards = {{f.emulator.device(0), 4, 4}, {f.emulator.device(1), 4, 0}, {f.emulator.device(2)}};
  f.gateway = *Gateway::create(config);
  ASSERT_TRUE(f.connect() && f.start());
  std::vector<double> speeds;
  for (int k = 0; k < 8; ++k) speeds.push_back(400 + 50.0 * k);
  ASSERT_TRUE(f.hold(speeds, 0.1));
  for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(f.plant.now.rotor_speed_radps[k], speeds[k], 0.5);
}

TEST(Gateway, RealTimeInTwoThreads) {
  const auto begin = std::chrono::steady_clock::now();
  const auto now = [begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  PtyFlight f;
  std::atomic<bool> done{false};
  std::thread board([&] {
    while (!done) {
      ASSERT_TRUE(f.emulator.step(now()));
      f.emulator.wait(5e-4);
    }
  });
  const auto run_until = [&](auto condition, double limit_s) {
    const double end_s = now() + limit_s;
    while (!condition() && now() < end_s) {
      f.gateway.wait(1e-3);
      const Status ok = f.gateway.poll(now());
      if (!ok) {
        ADD_FAILURE() << ok.error().text();
        break;
      }
    }
    return condition();
  };
  EXPECT_TRUE(f.gateway.connect(now()));
  EXPECT_TRUE(run_until([&] { return f.gateway.connected(); }, 1.5));
  EXPECT_TRUE(f.gateway.start_motors(now()));
  EXPECT_TRUE(run_until([&] { return f.gateway.phase() == GatewayPhase::running; }, 1.5));
  Telemetry t;
  f.gateway.fetch(t);
  run_until([] { return false; }, 0.3);
  f.gateway.fetch(t);
  EXPECT_GT(t.imu.size(), 100u);
  EXPECT_GT(t.rotors.size(), 8 * 15u);
  done = true;
  board.join();
}

}  // namespace
}  // namespace omniflight::gateway
