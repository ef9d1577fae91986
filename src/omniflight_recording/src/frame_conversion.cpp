#include "frame_conversion.hpp"

#include <cmath>

namespace omniflight::recording {
namespace {

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

/// R_EN = [0 1 0; 1 0 0; 0 0 -1]: half a turn about (1, 1, 0).
Quat enu_from_ned() { return {0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0}; }
/// diag(1, -1, -1): half a turn about x.
Quat frd_from_flu() { return {0.0, 1.0, 0.0, 0.0}; }

}  // namespace

Geometry geometry_of(std::string_view signal) {
  if (ends_with(signal, "attitude")) return Geometry::attitude;
  if (signal == "gyro" || signal == "acc" || ends_with(signal, "angular_velocity") ||
      ends_with(signal, "angular_acceleration"))
    return Geometry::body_vector;
  if (ends_with(signal, "position") || ends_with(signal, "velocity") || ends_with(signal, "acceleration"))
    return Geometry::world_vector;
  return Geometry::scalar;
}

std::string to_string(Axes axes) {
  switch (axes) {
    case Axes::ned:
      return "NED";
    case Axes::frd:
      return "FRD";
    case Axes::ned_frd:
      return "NED/FRD";
    default:
      return {};
  }
}

Vec3 to_our_axes(const Vec3& v, Axes axes) {
  if (axes == Axes::ned) return {v.y(), v.x(), -v.z()};
  if (axes == Axes::frd) return {v.x(), -v.y(), -v.z()};
  return v;
}

Quat to_our_axes(const Quat& q, Axes axes) {
  return axes == Axes::ned_frd ? enu_from_ned() * q * frd_from_flu() : q;
}

Vec3 turned_into_world(const Vec3& v_B, const Quat& q_WB, Axes axes) {
  const Vec3 v_W = q_WB.normalized() * v_B;
  return axes == Axes::frd ? to_our_axes(v_W, Axes::ned) : v_W;
}

}  // namespace omniflight::recording
