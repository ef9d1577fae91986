// A plant, an emulator and a gateway over real pseudo terminals, stepped in one thread in simulated time.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "omniflight_gateway/board_emulator.hpp"
#include "omniflight_gateway/gateway.hpp"

namespace omniflight::gateway {

/// Rotors that follow at once; battery and IMU as the test sets them.
class IdealPlant : public EmulatedPlant {
 public:
  void set_command(std::span<const double> speeds) override {
    now.rotor_speed_radps.assign(speeds.begin(), speeds.end());
  }
  PlantSample sample() override { return now; }
  PlantSample now;
};

class PtyFlight {
 public:
  explicit PtyFlight(EmulatorConfig boards = EmulatorConfig::omnimorph(), std::size_t rotors = 8)
      : emulator(*BoardEmulator::create(std::move(boards), plant)), gateway(make(emulator, rotors)) {
    plant.now.battery_V = 14.8;
    plant.now.rotor_current_A = {1.5, 0, 0, 0, 0, 0, 0, 2.25};
  }

  /// One step of both ends. Once connected, nothing is in flight between steps, however busy the machine is.
  Status tick() {
    now_s += 1e-3;
    land_commands();
    const Status emulated = emulator.step(now_s);
    EXPECT_TRUE(emulated) << emulated.error().text();
    Status status = gateway.poll(now_s, 2e-4);
    status = land_telemetry(status);
    gateway.fetch(batch);
    const auto append = [](auto& all, const auto& more) { all.insert(all.end(), more.begin(), more.end()); };
    append(seen.imu, batch.imu);
    append(seen.rotors, batch.rotors);
    append(seen.battery, batch.battery);
    append(seen.notices, batch.notices);
    return status;
  }
  /// Ticks until done() or limit_s of simulated time; the last status.
  Status until(const std::function<bool()>& done, double limit_s) {
    const double end_s = now_s + limit_s;
    Status status;
    while (now_s < end_s && !done()) {
      status = tick();
      if (!status) return status;
    }
    return status;
  }
  /// @param lockstep false: leave bytes in flight between steps, as a connection in real time does.
  bool connect(bool lockstep = true) {
    up_lost.clear();
    down_lost.clear();
    const Status opened = gateway.connect(now_s);
    EXPECT_TRUE(opened) << opened.error().text();
    const Status status = until([&] { return gateway.connected(); }, 2.0);
    EXPECT_TRUE(status) << status.error().text();
    if (lockstep) measure_lines();
    return gateway.connected();
  }
  bool start() {
    const Status asked = gateway.start_motors(now_s);
    EXPECT_TRUE(asked) << asked.error().text();
    const Status status = until([&] { return gateway.phase() == GatewayPhase::running; }, 3.0);
    EXPECT_TRUE(status) << status.error().text();
    return gateway.phase() == GatewayPhase::running;
  }
  /// Sends the same speeds every step for a while.
  Status hold(const std::vector<double>& speeds, double duration_s) {
    const double end_s = now_s + duration_s;
    while (now_s < end_s) {
      if (auto ok = gateway.send_velocities(speeds); !ok) return ok;
      if (auto ok = tick(); !ok) return ok;
    }
    return {};
  }

  static Gateway make(const BoardEmulator& emulator, std::size_t rotors) {
    GatewayConfig config;
    config.rotors = rotors;
    for (std::size_t i = 0; i < emulator.board_count(); ++i) config.boards.push_back({emulator.device(i)});
    return *Gateway::create(config);
  }

  // Bytes each side has moved, less what was lost to flushing while a line was opened.
  bool line_up(std::size_t i) const { return gateway.link(i).is_open() && emulator.plugged(i); }
  void measure_lines() {
    const auto quiet = [&] {
      const std::uint64_t before = traffic();
      wait_readable({}, 0.02);
      (void)gateway.poll(now_s);
      (void)emulator.receive(now_s);
      return traffic() == before;
    };
    for (int i = 0; i < 50 && !quiet(); ++i) {
    }
    up_lost.assign(emulator.board_count(), 0);
    down_lost = up_lost;
    for (std::size_t i = 0; i < up_lost.size(); ++i) {
      up_lost[i] = emulator.bytes_written(i) - gateway.link(i).bytes_read();
      down_lost[i] = gateway.link(i).bytes_written() - emulator.bytes_read(i);
    }
  }
  std::uint64_t traffic() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < emulator.board_count(); ++i)
      sum += gateway.link(i).bytes_read() + emulator.bytes_read(i);
    return sum;
  }
  void land_commands() {
    for (std::size_t i = 0; i < down_lost.size(); ++i) {
      for (int n = 0; n < 1000 && line_up(i); ++n) {
        if (emulator.bytes_read(i) + down_lost[i] >= gateway.link(i).bytes_written()) break;
        emulator.wait(1e-3);
        EXPECT_TRUE(emulator.receive(now_s));
      }
    }
  }
  Status land_telemetry(Status status) {
    for (std::size_t i = 0; i < up_lost.size(); ++i) {
      for (int n = 0; n < 1000 && status && line_up(i); ++n) {
        if (gateway.link(i).bytes_read() + up_lost[i] >= emulator.bytes_written(i)) break;
        status = gateway.poll(now_s, 1e-3);
      }
    }
    return status;
  }

  std::vector<std::uint64_t> up_lost, down_lost;
  double now_s = 0.0;
  IdealPlant plant;
  BoardEmulator emulator;
  Gateway gateway;
  Telemetry seen, batch;
};

}  // namespace omniflight::gateway
