#include "omniflight_recording/axes.hpp"

#include "frame_conversion.hpp"

namespace omniflight::recording {
namespace {

Axes foreign_axes(Geometry geometry) {
  switch (geometry) {
    case Geometry::world_vector:
      return Axes::ned;
    case Geometry::body_vector:
      return Axes::frd;
    case Geometry::attitude:
      return Axes::ned_frd;
    default:
      return Axes::as_they_are;
  }
}

}  // namespace

Status turn_from_ned(Recording& r) {
  for (const auto& [name, s] : r.signals) {
    const Geometry geometry = geometry_of(name);
    if (geometry == Geometry::scalar) continue;
    if (s.source.find("converted from") != std::string::npos)
      return bad_input("is " + s.source + ": NED is not to be turned twice", r.file + ", " + name,
                       "Leave --axes out, or give a map that says the frames of this log (--map)");
    if (s.width() != (geometry == Geometry::attitude ? 4 : 3))
      return bad_input("has " + std::to_string(s.width()) + " components", r.file + ", " + name,
                       "Leave --axes out, and give a map that says the frames of this log (--map)");
  }
  std::string turned;
  for (auto& [name, s] : r.signals) {
    const Axes from = foreign_axes(geometry_of(name));
    if (from == Axes::as_they_are) continue;
    for (Eigen::Index i = 0; i < s.size(); ++i) {
      auto row = s.values.row(i);
      if (from == Axes::ned_frd) {
        const Quat q = to_our_axes(Quat(row[0], row[1], row[2], row[3]), from);
        row << q.w(), q.x(), q.y(), q.z();
      } else {
        row = to_our_axes(Vec3(row[0], row[1], row[2]), from).transpose();
      }
    }
    s.source += ", converted from " + to_string(from);
    turned += (turned.empty() ? "" : ", ") + name + " from " + to_string(from);
  }
  r.note(Note::Kind::information, "turned to east, north, up and forward, left, up as told: " + turned);
  return {};
}

}  // namespace omniflight::recording
