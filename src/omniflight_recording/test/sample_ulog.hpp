// Writes ULog files of a made-up flight: a circle at 1 m, nose to the centre of it, leaning inwards.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_recording/formats.hpp"

namespace sample {

/// Little-endian bytes, packed.
class Packed {
 public:
  template <class T>
  Packed& put(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Packed& raw(const std::string& text) {
    text_ += text;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class Ulog {
 public:
  explicit Ulog(std::uint64_t start_us = 5'000'000) {
    bytes_ = std::string("ULog\x01\x12\x35\x01", 8) + Packed().put(start_us).text();
  }
  Ulog& record(char type, const std::string& body) {
    bytes_ += Packed().put(static_cast<std::uint16_t>(body.size())).put(type).raw(body).text();
    boundaries_.push_back(bytes_.size());
    return *this;
  }
  Ulog& flags(std::uint8_t incompatible, std::uint64_t offset = 0) {
    std::string body(40, '\0');
    body[8] = static_cast<char>(incompatible);
    body.replace(16, 8, Packed().put(offset).text());
    return record('B', body);
  }
  Ulog& format(const std::string& text) { return record('F', text); }
  Ulog& info(const std::string& key, const std::string& value) {
    return record('I', Packed().put(static_cast<std::uint8_t>(key.size())).raw(key + value).text());
  }
  Ulog& parameter(const std::string& name, float value) {
    const std::string key = "float " + name;
    return record('P', Packed().put(static_cast<std::uint8_t>(key.size())).raw(key).put(value).text());
  }
  Ulog& parameter(const std::string& name, std::int32_t value) {
    const std::string key = "int32_t " + name;
    return record('P', Packed().put(static_cast<std::uint8_t>(key.size())).raw(key).put(value).text());
  }
  Ulog& subscribe(std::uint16_t id, const std::string& name, std::uint8_t instance = 0) {
    return record('A', Packed().put(instance).put(id).raw(name).text());
  }
  Ulog& data(std::uint16_t id, const Packed& message) {
    return record('D', Packed().put(id).raw(message.text()).text());
  }
  Ulog& text(char level, std::uint64_t us, const std::string& what) {
    return record('L', Packed().put(level).put(us).raw(what).text());
  }
  Ulog& dropout(std::uint16_t ms) { return record('O', Packed().put(ms).text()); }
  Ulog& sync() { return record('S', std::string("\x2f\x73\x13\x20\x25\x0c\xbb\x12", 8)); }
  Ulog& append(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }

  const std::string& bytes() const { return bytes_; }
  const std::vector<std::size_t>& boundaries() const { return boundaries_; }  // ends of records

 private:
  std::string bytes_;
  std::vector<std::size_t> boundaries_;
};

/// The flight in our axes (ENU, FLU) at t [s].
struct Moment {
  omniflight::Vec3 p_WB, v_WB, w_B;
  omniflight::Quat q_WB;
};
inline Moment moment(double t) {
  using omniflight::Vec3;
  Moment m;
  m.p_WB = Vec3(2 * std::cos(t), 2 * std::sin(t), 1 + 0.1 * t);
  m.v_WB = Vec3(-2 * std::sin(t), 2 * std::cos(t), 0.1);
  m.q_WB = omniflight::from_roll_pitch_yaw(Vec3(0, 0.2, t + omniflight::kPi));
  m.w_B = m.q_WB.conjugate() * Vec3(0, 0, 1);
  return m;
}

inline omniflight::Vec3 ned(const omniflight::Vec3& v) { return {v.y(), v.x(), -v.z()}; }
inline omniflight::Vec3 frd(const omniflight::Vec3& v) { return {v.x(), -v.y(), -v.z()}; }
/// NED <- FRD by matrices, another way than the code under test goes.
inline omniflight::Quat ned_frd(const omniflight::Quat& q) {
  omniflight::Mat3 to_ned, to_flu;
  to_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  to_flu << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return omniflight::Quat(omniflight::Mat3(to_ned * q.toRotationMatrix() * to_flu));
}
inline Packed& put(Packed& p, const omniflight::Vec3& v) {
  for (int i = 0; i < 3; ++i) p.put(static_cast<float>(v(i)));
  return p;
}

inline void declare_flight(Ulog& log) {
  log.flags(0)
      .info("char[3] sys_name", "PX4")
      .info("char[9] ver_hw", "MADE_UP_1")
      .info("uint32_t ver_sw_release", Packed().put(std::uint32_t{0x010e00ff}).text())
      .format(
          "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
          "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint8_t[4] _padding0;")
      .format(
          "vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;uint8_t[7] _padding0;")
      .format(
          "vehicle_local_position:uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z;"
          "float vx;float vy;float vz;bool xy_valid;bool z_valid;bool v_xy_valid;bool v_z_valid;")
      .format("esc_report:uint64_t timestamp;int32_t esc_rpm;float esc_voltage;uint8_t[3] _padding0;")
      .format("esc_status:uint64_t timestamp;uint8_t esc_count;uint8_t[7] _padding0;esc_report[8] esc;")
      .format("actuator_motors:uint64_t timestamp;float[12] control;")
      .format("battery_status:uint64_t timestamp;float voltage_v;float current_a;")
      .parameter("CA_ROTOR_COUNT", std::int32_t{4})
      .parameter("MAV_TYPE", std::int32_t{2})
      .parameter("MPC_THR_HOVER", 0.42f)
      .parameter("BAT1_N_CELLS", std::int32_t{4});
  for (int i = 0; i < 4; ++i) {
    const std::string name = "CA_ROTOR" + std::to_string(i) + "_";
    const float x = i == 0 || i == 2 ? 0.15f : -0.15f, y = i == 0 || i == 3 ? 0.2f : -0.2f;
    log.parameter(name + "PX", x).parameter(name + "PY", y).parameter(name + "KM", i < 2 ? 0.05f : -0.05f);
  }
  log.subscribe(0, "sensor_combined")
      .subscribe(1, "vehicle_attitude")
      .subscribe(2, "vehicle_local_position")
      .subscribe(3, "esc_status")
      .subscribe(4, "actuator_motors")
      .subscribe(5, "battery_status")
      .subscribe(6, "battery_status", 1);
}

/// One millisecond-step of the flight: IMU always, the rest with every tenth.
inline void fly_step(Ulog& log, std::uint64_t k, std::uint64_t start_us = 5'000'000) {
  const std::uint64_t us = start_us + k * 1000;
  const Moment m = moment(1e-3 * static_cast<double>(k));
  Packed imu;
  put(imu.put(us), frd(m.w_B)).put(std::uint32_t{1000}).put(std::int32_t{0});
  put(imu, frd(m.q_WB.conjugate() * omniflight::Vec3(0, 0, 9.81)));
  log.data(0, imu);
  if (k % 10 != 0) return;
  const omniflight::Quat q = ned_frd(m.q_WB);
  Packed attitude;
  attitude.put(us + 200).put(us);
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) attitude.put(static_cast<float>(value));
  log.data(1, attitude.raw(std::string(k % 20 == 0 ? 0 : 7, '\0')));  // loggers write the padding, or not
  Packed place;
  put(put(place.put(us + 300).put(us), ned(m.p_WB)), ned(m.v_WB));
  log.data(2, place.raw(std::string("\x01\x01\x01\x01", 4)));
  Packed esc;
  esc.put(us).put(std::uint8_t{4}).raw(std::string(7, '\0'));
  for (int i = 0; i < 8; ++i)
    esc.put(us).put(std::int32_t{i < 4 ? 6000 + 60 * i : 0}).put(15.5f).raw(std::string(3, '\0'));
  log.data(3, esc);
  Packed motors;
  motors.put(us);
  for (int i = 0; i < 12; ++i) motors.put(i < 4 ? 0.4f + 0.01f * static_cast<float>(i) : std::nanf(""));
  log.data(4, motors);
  log.data(5, Packed().put(us).put(15.5f).put(-1.0f));
  log.data(6, Packed().put(us).put(11.1f).put(3.0f));
  if (k % 100 == 0) log.sync();
}

inline Ulog flight_log(std::uint64_t steps) {
  Ulog log;
  declare_flight(log);
  for (std::uint64_t k = 0; k < steps; ++k) fly_step(log, k);
  return log;
}

/// Reads bytes by the format of that name, with the shipped maps.
inline omniflight::Result<omniflight::recording::Recording> read_as(
    const std::string& name, std::string_view bytes, const omniflight::recording::LoadOptions& options = {}) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  for (const auto& format : omniflight::recording::formats())
    if (name == format.name) return format.read(bytes, "made_up." + name, options);
  return omniflight::bad_input("there is no such format", name);
}

}  // namespace sample
