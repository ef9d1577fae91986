// Writes what rotorcraft-genom3 logs, of a made-up hover of a hexarotor (synthetic).
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace sample {

/// Rows at 1 kHz, IMU at 500 Hz, motors at 100 Hz; rotors 7 and 8 do not exist.
inline std::string genom3_log(int rows, bool gap = false) {
  std::string out =
      "ts imu_rate mag_rate motor_rate imu_wx imu_wy imu_wz  imu_ax imu_ay imu_az  mag_x mag_y mag_z "
      "cmd_v0 cmd_v1 cmd_v2 cmd_v3 cmd_v4 cmd_v5 cmd_v6 cmd_v7 "
      "meas_v0 meas_v1 meas_v2 meas_v3 meas_v4 meas_v5 meas_v6 meas_v7 clk0 clk1 clk2 clk3 clk4 clk5 clk6 "
      "clk7\n";
  char cell[64];
  for (int k = 0; k < rows; ++k) {
    const double imu = 0.002 * (k / 2), motor = 0.01 * (k / 10);
    if (gap && k == rows / 2) out += "\n";
    std::snprintf(cell, sizeof cell, "%d.%09d ", 1700000000 + k / 1000, k % 1000 * 1000000);
    out += cell;
    out += "500 100 100 ";
    for (const double value :
         {0.1 * std::sin(imu), 0.1 * std::cos(imu), imu, 0.01, -0.01, 9.81 + 0.1 * std::sin(imu)}) {
      std::snprintf(cell, sizeof cell, "%g ", value);
      out += cell;
    }
    out += "nan nan nan ";
    for (int i = 0; i < 8; ++i) out += i < 6 ? std::to_string(100 + i) + " " : "0 ";
    for (int i = 0; i < 8; ++i) {
      std::snprintf(cell, sizeof cell, i < 6 ? "%g " : "nan ", 100 + i + motor);
      out += cell;
    }
    out += "0 0 0 0 0 0 0 0\n";
  }
  return out;
}

}  // namespace sample
