// Between Eigen and the C structs of messages.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "omniflight_bus/message.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_core/trajectory.hpp"

namespace omniflight::components {

inline std::int64_t to_ns(double t_s) { return static_cast<std::int64_t>(std::llround(t_s * 1e9)); }
inline double to_s(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }
inline double to_s(const bus::Time& t) { return to_s(bus::nanoseconds(t)); }

template <class M>
void put(M& field, const Vec3& v) {
  field.x = v.x();
  field.y = v.y();
  field.z = v.z();
}
template <class M>
void put_quaternion(M& field, const Quat& q) {
  field.x = q.x();
  field.y = q.y();
  field.z = q.z();
  field.w = q.w();
}
template <class M>
Vec3 get(const M& field) {
  return {field.x, field.y, field.z};
}
template <class M>
Quat get_quaternion(const M& field) {
  return Quat(field.w, field.x, field.y, field.z);
}
inline void put(double (&field)[3], const Vec3& v) { std::copy_n(v.data(), 3, field); }
inline void put(double (&field)[6], const Vec6& v) { std::copy_n(v.data(), 6, field); }
inline void put(double (&field)[4], const Quat& q) {
  field[0] = q.w();
  field[1] = q.x();
  field[2] = q.y();
  field[3] = q.z();
}
inline Vec3 get(const double (&field)[3]) { return {field[0], field[1], field[2]}; }
inline Vec6 get(const double (&field)[6]) { return Eigen::Map<const Vec6>(field); }
inline Quat get(const double (&field)[4]) { return Quat(field[0], field[1], field[2], field[3]); }

/// Splits "a;b;c" as parameters carry lists of overrides.
inline std::vector<std::string> split(const std::string& text, char separator = ';') {
  std::vector<std::string> out;
  std::string item;
  for (const char c : text + separator) {
    if (c != separator) {
      item += c;
    } else if (!item.empty()) {
      out.push_back(std::move(item));
      item.clear();
    }
  }
  return out;
}

}  // namespace omniflight::components
