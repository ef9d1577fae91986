// Writes Crazyflie micro-SD logs of the made-up flight (synthetic): IMU and rotors at 1 kHz, poses at 100 Hz.
#pragma once

#include <zlib.h>

#include "sample_bag1.hpp"
#include "sample_ulog.hpp"

namespace sample {

inline std::string event_type(std::uint16_t id, const std::string& name,
                              const std::vector<std::string>& variables) {
  std::string out = bytes_of(id) + name + '\0' + bytes_of(static_cast<std::uint16_t>(variables.size()));
  for (const std::string& v : variables) out += v + '\0';
  return out;
}

inline std::string microsd_log(std::uint64_t steps) {
  std::string out = "\xbc" + bytes_of(std::uint16_t{2}) + bytes_of(std::uint16_t{2});
  out += event_type(1, "fixedFrequency",
                    {"gyro.x(f)", "gyro.y(f)", "gyro.z(f)", "acc.x(f)", "acc.y(f)", "acc.z(f)", "rpm.m1(H)",
                     "rpm.m2(H)", "rpm.m3(H)", "rpm.m4(H)", "pm.vbatMV(H)"});
  out += event_type(2, "estPose",
                    {"locSrv.x(f)", "locSrv.y(f)", "locSrv.z(f)", "locSrv.qx(f)", "locSrv.qy(f)",
                     "locSrv.qz(f)", "locSrv.qw(f)"});
  for (std::uint64_t k = 0; k < steps; ++k) {
    const Moment m = moment(1e-3 * static_cast<double>(k));
    const std::uint64_t us = 3'000'000 + 1000 * k;
    out += bytes_of(std::uint16_t{1}) + bytes_of(us);
    for (int i = 0; i < 3; ++i) out += bytes_of(static_cast<float>(m.w_B(i) * 180 / omniflight::kPi));
    const omniflight::Vec3 up = m.q_WB.conjugate() * omniflight::Vec3(0, 0, 1);  // in units of g
    for (int i = 0; i < 3; ++i) out += bytes_of(static_cast<float>(up(i)));
    for (int i = 0; i < 4; ++i) out += bytes_of(static_cast<std::uint16_t>(15000 + i));
    out += bytes_of(static_cast<std::uint16_t>(3900));
    if (k % 10 != 0) continue;
    out += bytes_of(std::uint16_t{2}) + bytes_of(us);
    for (int i = 0; i < 3; ++i) out += bytes_of(static_cast<float>(m.p_WB(i)));
    for (const double q : {m.q_WB.x(), m.q_WB.y(), m.q_WB.z(), m.q_WB.w()})
      out += bytes_of(static_cast<float>(q));
  }
  const auto crc = crc32(0, reinterpret_cast<const Bytef*>(out.data()), static_cast<uInt>(out.size()));
  return out + bytes_of(static_cast<std::uint32_t>(crc));
}

}  // namespace sample
