// From the axes of other systems to ours: world east, north, up; body forward, left, up (REP-103).
#pragma once

#include <string>
#include <string_view>

#include "omniflight_core/frames.hpp"

namespace omniflight::recording {

/// Axes in which a log has a vector or an attitude.
enum class Axes {
  as_they_are,  ///< ENU and FLU already
  ned,          ///< world vector: north, east, down
  frd,          ///< body vector: forward, right, down
  ned_frd,      ///< attitude: NED <- FRD
};

/// What a signal is, geometrically.
enum class Geometry { scalar, world_vector, body_vector, attitude };
Geometry geometry_of(std::string_view signal);

/// "NED", "FRD", "NED/FRD", or nothing.
std::string to_string(Axes axes);

/// (x, y, z) of NED to ENU, or of FRD to FLU; other axes are left.
Vec3 to_our_axes(const Vec3& v, Axes axes);

/// ENU <- FLU of an attitude NED <- FRD; other axes are left.
Quat to_our_axes(const Quat& q, Axes axes);

/// A vector in body axes (`axes`: frd, otherwise flu), turned into the world (ENU) by the attitude of the
/// same message in the same convention (NED <- FRD, otherwise ENU <- FLU).
Vec3 turned_into_world(const Vec3& v_B, const Quat& q_WB, Axes axes);

}  // namespace omniflight::recording
