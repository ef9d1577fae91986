// Writes ROS 1 bags of the made-up flight: IMU and odometry, in chunks of any compression.
#pragma once

#include <bzlib.h>
#include <lz4frame.h>

#include <map>
#include <stdexcept>

#include "sample_ulog.hpp"

namespace sample {

inline std::string with_length(const std::string& text) {
  return Packed().put(static_cast<std::uint32_t>(text.size())).raw(text).text();
}
inline std::string bag_record(const std::map<std::string, std::string>& fields, const std::string& data) {
  std::string header;
  for (const auto& [name, value] : fields) header += with_length(name + "=" + value);
  return with_length(header) + with_length(data);
}
template <class T>
std::string bytes_of(T value) {
  return Packed().put(value).text();
}
inline std::string op(char code) { return std::string(1, code); }

inline const char* kHeader1 =
    "================================================================================\n"
    "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
inline const char* kVectors1 =
    "================================================================================\n"
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
inline std::string imu_definition1() {
  return std::string(
             "Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
             "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
             "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n") +
         kHeader1 + kVectors1;
}
inline std::string odometry_definition1() {
  return std::string(
             "Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
             "geometry_msgs/TwistWithCovariance twist\n") +
         kHeader1 + kVectors1 +
         "====\nMSG: geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n"
         "====\nMSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n"
         "====\nMSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n"
         "====\nMSG: geometry_msgs/Twist\nVector3 linear\nVector3 angular\n";
}

inline Packed& put_doubles(Packed& p, std::initializer_list<double> values) {
  for (const double v : values) p.put(v);
  return p;
}
inline Packed& put_zeros(Packed& p, int count) {
  for (int i = 0; i < count; ++i) p.put(0.0);
  return p;
}
inline Packed header1(std::uint32_t sequence, std::uint64_t ns) {
  Packed p;
  p.put(sequence)
      .put(static_cast<std::uint32_t>(ns / 1'000'000'000))
      .put(static_cast<std::uint32_t>(ns % 1'000'000'000))
      .raw(with_length("map"));
  return p;
}
inline std::string imu_message1(std::uint32_t sequence, std::uint64_t ns, const Moment& m) {
  Packed p = header1(sequence, ns);
  put_doubles(p, {0, 0, 0, 0, -1});  // no orientation
  put_zeros(p, 8);
  put_doubles(p, {m.w_B.x(), m.w_B.y(), m.w_B.z()});
  put_zeros(p, 9);
  const omniflight::Vec3 f_B = m.q_WB.conjugate() * omniflight::Vec3(0, 0, 9.81);
  put_doubles(p, {f_B.x(), f_B.y(), f_B.z()});
  return put_zeros(p, 9).text();
}
inline std::string odometry_message1(std::uint32_t sequence, std::uint64_t ns, const Moment& m) {
  Packed p = header1(sequence, ns);
  p.raw(with_length("body"));
  put_doubles(p, {m.p_WB.x(), m.p_WB.y(), m.p_WB.z(), m.q_WB.x(), m.q_WB.y(), m.q_WB.z(), m.q_WB.w()});
  put_zeros(p, 36);
  const omniflight::Vec3 v_B = m.q_WB.conjugate() * m.v_WB;  // a twist is in body axes
  put_doubles(p, {v_B.x(), v_B.y(), v_B.z(), m.w_B.x(), m.w_B.y(), m.w_B.z()});
  return put_zeros(p, 36).text();
}

inline std::string packed_with(const std::string& compression, const std::string& records) {
  if (compression == "none") return records;
  std::string out(records.size() + records.size() / 50 + 1000, '\0');
  if (compression == "lz4") {
    const std::size_t n = LZ4F_compressFrame(out.data(), out.size(), records.data(), records.size(), nullptr);
    if (LZ4F_isError(n)) throw std::runtime_error("lz4");
    out.resize(n);
  } else {
    auto n = static_cast<unsigned>(out.size());
    std::string in = records;
    if (BZ2_bzBuffToBuffCompress(out.data(), &n, in.data(), static_cast<unsigned>(in.size()), 9, 0, 0) !=
        BZ_OK)
      throw std::runtime_error("bz2");
    out.resize(n);
  }
  return out;
}

inline std::string connection1(std::uint32_t id, const std::string& topic, const std::string& type,
                               const std::string& definition) {
  std::string data = with_length("topic=" + topic) + with_length("type=" + type) +
                     with_length("md5sum=made up") + with_length("message_definition=" + definition);
  return bag_record({{"op", op(7)}, {"conn", bytes_of(id)}, {"topic", topic}}, data);
}
inline std::string message1(std::uint32_t id, std::uint64_t ns, const std::string& data) {
  const std::uint64_t time = (ns % 1'000'000'000) << 32 | ns / 1'000'000'000;
  return bag_record({{"op", op(2)}, {"conn", bytes_of(id)}, {"time", bytes_of(time)}}, data);
}

/// `steps` of a millisecond from start_ns: IMU always, odometry with every tenth; a chunk every 50 steps.
inline std::string flight_bag1(const std::string& compression, std::uint32_t steps,
                               std::uint64_t start_ns = 1'700'000'000'000'000'000, bool closed = true) {
  const std::uint32_t chunks = (steps + 49) / 50;
  std::string head = bag_record({{"op", op(3)},
                                 {"index_pos", bytes_of(std::uint64_t{closed ? 4117u : 0u})},
                                 {"conn_count", bytes_of(std::uint32_t{2})},
                                 {"chunk_count", bytes_of(chunks)}},
                                std::string(4027, ' '));
  std::string bag = "#ROSBAG V2.0\n" + head;
  for (std::uint32_t k = 0; k < steps;) {
    std::string records;
    std::uint32_t imus = 0, odometries = 0;
    if (k == 0)
      records = connection1(0, "/imu", "sensor_msgs/Imu", imu_definition1()) +
                connection1(1, "/odom", "nav_msgs/Odometry", odometry_definition1());
    do {
      const std::uint64_t ns = start_ns + k * std::uint64_t{1'000'000};
      const Moment m = moment(1e-3 * k);
      records += message1(0, ns + 100'000, imu_message1(k, ns, m));
      ++imus;
      if (k % 10 == 0) {
        records += message1(1, ns + 200'000, odometry_message1(k, ns, m));
        ++odometries;
      }
    } while (++k < steps && k % 50 != 0);
    bag += bag_record({{"op", op(5)},
                       {"compression", compression},
                       {"size", bytes_of(static_cast<std::uint32_t>(records.size()))}},
                      packed_with(compression, records));
    for (const auto& [id, count] : {std::pair<std::uint32_t, std::uint32_t>{0, imus}, {1, odometries}})
      bag += bag_record(
          {{"op", op(4)}, {"ver", bytes_of(1u)}, {"conn", bytes_of(id)}, {"count", bytes_of(count)}},
          std::string(12 * count, '\0'));
  }
  return bag;
}

}  // namespace sample
