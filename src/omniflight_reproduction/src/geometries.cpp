#include "geometries.hpp"

#include <fmt/format.h>

#include <cmath>

namespace omniflight::reproduction {
namespace {

constexpr double kArrow = 0.09;       // m, drawn length of a normal
constexpr double kHalfWidth = 0.004;  // m, of an arrow's foot and of a tilt axis
constexpr int kCorners = 28;          // of a drawn disc

using Points = std::vector<std::pair<double, double>>;

/// The rim of the disc, then out along the normal and back: one closed line a rotor.
Points rotor_shape(const vehicle::Rotor& r, const Vec3& n, int across, int up) {
  const Vec3 u = n.unitOrthogonal(), w = n.cross(u);
  Points out;
  for (int k = 0; k <= kCorners; ++k) {
    const double a = 2 * kPi * k / kCorners;
    const Vec3 p = r.p_BR + 0.6 * r.radius * (std::cos(a) * u + std::sin(a) * w);
    out.emplace_back(p[across], p[up]);
  }
  const Vec3 tip = r.p_BR + kArrow * n;
  out.emplace_back(r.p_BR[across], r.p_BR[up]);
  out.emplace_back(tip[across], tip[up]);
  out.emplace_back(r.p_BR[across], r.p_BR[up]);
  if (r.tilts) {
    for (const double end : {-1.0, 1.0}) {
      const Vec3 p = r.p_BR + end * kArrow * 0.8 * r.tilt_axis_B, side = kHalfWidth * Vec3::UnitZ();
      out.emplace_back((p + side)[across], (p + side)[up]);
      out.emplace_back((p - side)[across], (p - side)[up]);
    }
    out.emplace_back(r.p_BR[across], r.p_BR[up]);
  }
  return out;
}

}  // namespace

double isotropic_tilt() { return std::acos(1 / std::sqrt(3.0)); }

std::vector<double> compared_tilts() { return {to_radians(30), to_radians(45), isotropic_tilt()}; }

vehicle::Vehicle without_drag(vehicle::Vehicle v) {
  for (auto& rotor : v.rotors) rotor.drag_ratio = 0;
  return v;
}

vehicle::Vehicle choice_1(const vehicle::Vehicle& omnimorph) {
  vehicle::Vehicle v = omnimorph;
  const Quat back(Eigen::AngleAxisd(-to_radians(15), Vec3::UnitZ()));
  for (auto& rotor : v.rotors) rotor.tilt_axis_B = back * rotor.tilt_axis_B;
  return v;
}

vehicle::Vehicle omnicopter_on_cube(const Inputs& inputs) {
  vehicle::Vehicle v = inputs.omnimorph;
  v.name = "omnicopter on OmniMorph's cube";
  v.tilt = {};
  for (std::size_t i = 0; i < v.rotors.size() && i < inputs.omnicopter.rotors.size(); ++i) {
    const auto& from = inputs.omnicopter.rotors[i];
    const double size = v.rotors[i].p_BR.norm();
    v.rotors[i].p_BR = size * from.p_BR.normalized();
    v.rotors[i].axis_B = from.axis_B;
    v.rotors[i].tilts = false;
  }
  return v;
}

report::Outlines drawing(const vehicle::Vehicle& v, double alpha, const std::string& title) {
  report::Outlines out{.title = title,
                       .views = {{.x_label = "x [m]", .y_label = "y [m], from above"},
                                 {.x_label = "x [m]", .y_label = "z [m], from the side"}}};
  for (int i = 0; i < v.rotor_count(); ++i) {
    const auto& rotor = v.rotors[static_cast<std::size_t>(i)];
    const Vec3 n = v.rotor_axis(i, alpha);
    const std::string name = fmt::format("rotor {}", i + 1);
    out.views[0].outlines.push_back({name, rotor_shape(rotor, n, 0, 1)});
    out.views[1].outlines.push_back({name, rotor_shape(rotor, n, 0, 2)});
  }
  return out;
}

}  // namespace omniflight::reproduction
