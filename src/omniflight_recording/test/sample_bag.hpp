// A small flight as an MCAP file: IMU at 1 kHz and pose at 100 Hz with values that follow from the time.
#pragma once

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "omniflight_recording/formats.hpp"
#include "omniflight_recording/mcap_writer.hpp"

namespace sample {

inline const char* kHeaderTypes =
    "================================================================================\n"
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
inline const char* kVectorTypes =
    "================================================================================\n"
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n";

inline omniflight::recording::McapTopic imu_topic() {
  return {
      "/omniflight/imu", "sensor_msgs/msg/Imu",
      std::string("# comment\nstd_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
                  "float64[9] orientation_covariance # Row major\ngeometry_msgs/Vector3 angular_velocity\n"
                  "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
                  "float64[9] linear_acceleration_covariance\n") +
          kHeaderTypes + kVectorTypes,
      "- history: keep_last\n  depth: 10\n", "RIHS01_00"};
}
inline omniflight::recording::McapTopic pose_topic() {
  return {"/omniflight/mocap", "geometry_msgs/msg/PoseStamped",
          std::string("std_msgs/Header header\nPose pose\n"
                      "================================================================================\n"
                      "MSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n") +
              kHeaderTypes + kVectorTypes,
          "- history: keep_last\n  depth: 10\n", ""};
}

/// Little-endian XCDR1 with its encapsulation header.
class Cdr {
 public:
  template <class T>
  Cdr& put(T value) {
    while ((text_.size() - 4) % sizeof(T) != 0) text_ += '\0';
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Cdr& string(const std::string& s) {
    put(static_cast<std::uint32_t>(s.size() + 1));
    text_ += s;
    text_ += '\0';
    return *this;
  }
  Cdr& stamp(std::uint64_t ns) {
    return put(static_cast<std::int32_t>(ns / 1'000'000'000))
        .put(static_cast<std::uint32_t>(ns % 1'000'000'000));
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_{std::string("\0\1\0\0", 4)};
};

inline std::string imu_message(std::uint64_t ns) {
  const double t = 1e-9 * static_cast<double>(ns);
  Cdr c;
  c.stamp(ns).string("body");
  for (int i = 0; i < 4 + 9; ++i) c.put(0.0);
  c.put(std::sin(t)).put(std::cos(t)).put(t);
  for (int i = 0; i < 9; ++i) c.put(0.0);
  c.put(0.1).put(-0.1).put(9.81 + t);
  for (int i = 0; i < 9; ++i) c.put(0.0);
  return c.text();
}
inline std::string pose_message(std::uint64_t ns) {
  const double t = 1e-9 * static_cast<double>(ns);
  Cdr c;
  c.stamp(ns).string("world");
  c.put(t).put(2 * t).put(3 * t);
  c.put(std::sin(t / 2)).put(0.0).put(0.0).put(std::cos(t / 2));  // x y z w
  return c.text();
}

/// Tests stop when a step that must work does not.
inline void need(const omniflight::Status& status) {
  if (!status) throw std::runtime_error(status.error().text());
}

/// Writes `count` IMU messages (and a pose with every tenth) to path.
inline void write_flight(const std::filesystem::path& path, std::uint64_t count, std::size_t chunk_bytes,
                         std::uint64_t start_ns = 0) {
  omniflight::recording::McapWriterOptions options;
  options.chunk_bytes = chunk_bytes;
  options.overwrite = true;
  auto writer = omniflight::recording::McapWriter::create(path, options);
  if (!writer) throw std::runtime_error(writer.error().text());
  auto& w = **writer;
  const auto imu = w.add_topic(imu_topic()).value(), pose = w.add_topic(pose_topic()).value();
  need(w.write_metadata("omniflight.hashes", {{"vehicle", "abc"}}));
  need(w.write_attachment("vehicle.yaml", "text/yaml", start_ns, "mass: 1\n"));
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t now = start_ns + i * 1'000'000;
    need(w.write(imu, static_cast<std::uint32_t>(i), now, now, imu_message(now), now));
    if (i % 10 == 0)
      need(w.write(pose, static_cast<std::uint32_t>(i / 10), now, now, pose_message(now), now));
  }
  need(w.close());
}

inline std::string slurp(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Reads MCAP bytes without a file.
inline omniflight::Result<omniflight::recording::Recording> read_bytes(std::string_view bytes) {
  const auto& format = omniflight::recording::formats().front();
  return format.read(bytes, "memory.mcap", {});
}

}  // namespace sample
