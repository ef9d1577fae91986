// What the boards say, in SI units and by global rotor id.
#pragma once

#include <cstdint>
#include <omniflight_core/frames.hpp>
#include <string>
#include <vector>

#include "omniflight_gateway/tk3_codec.hpp"

namespace omniflight::gateway {

struct ImuSample {
  double time_s = 0.0;     ///< s, host clock, rebuilt from the sequence number
  double arrival_s = 0.0;  ///< s, host clock, when it was read
  std::uint8_t seq = 0;
  unsigned missed = 0;             ///< samples lost just before this one
  Vec3 specific_force_B{0, 0, 0};  ///< m/s^2
  Vec3 w_WB_B{0, 0, 0};            ///< rad/s
};

struct MagneticSample {
  double time_s = 0.0, arrival_s = 0.0;  ///< s, host clock
  std::uint8_t seq = 0;
  Vec3 field_B{0, 0, 0};  ///< T
};

struct RotorSample {
  double time_s = 0.0, arrival_s = 0.0;  ///< s, host clock
  std::uint8_t seq = 0;
  unsigned missed = 0;
  std::size_t rotor = 0;     ///< global id, 0-based
  double speed_radps = 0.0;  ///< signed, quantised to whole microseconds of half-period; 0 when not spinning
  double throttle = 0.0;     ///< share of full
  double current_A = 0.0;
  bool starting = false, spinning = false, emergency = false;
};

struct BatterySample {
  double arrival_s = 0.0;
  double voltage_V = 0.0;
};

struct BoardNotice {
  double arrival_s = 0.0;
  std::string device;
  BoardText::Severity severity = BoardText::Severity::info;
  std::string text;
};

struct Telemetry {
  std::vector<ImuSample> imu;
  std::vector<MagneticSample> magnetic;
  std::vector<RotorSample> rotors;
  std::vector<BatterySample> battery;
  std::vector<BoardNotice> notices;
  /// Empties the lists and keeps their memory.
  void clear() {
    imu.clear();
    magnetic.clear();
    rotors.clear();
    battery.clear();
    notices.clear();
  }
};

}  // namespace omniflight::gateway
