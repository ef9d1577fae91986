// OmniMorph as a plain struct: eight bidirectional rotors on the corners of a 0.25 m cube, tilt axes along
// its edges.
#pragma once

#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

inline vehicle::Vehicle omnimorph(double mass = 1.315, double max_thrust = 6.25) {
  vehicle::Vehicle v;
  v.name = "omnimorph";
  v.mass = mass;
  v.inertia = Vec3::Constant(0.0125).asDiagonal();
  v.tilt = {vehicle::TiltKind::common, 0.0, to_radians(60.0), to_radians(30.0)};
  const double h = 0.125;
  // corner signs and tilt axis
  const double layout[8][5] = {{1, 1, 1, 0, -1}, {-1, 1, 1, 1, 0},   {1, -1, 1, -1, 0}, {-1, -1, 1, 0, 1},
                               {1, 1, -1, 0, 1}, {-1, 1, -1, -1, 0}, {1, -1, -1, 1, 0}, {-1, -1, -1, 0, -1}};
  for (const auto& row : layout) {
    vehicle::Rotor r;
    r.p_BR = h * Vec3(row[0], row[1], row[2]);
    r.tilts = true;
    r.tilt_axis_B = Vec3(row[3], row[4], 0);
    r.spin = row[2] > 0 ? 1 : -1;
    r.thrust_coefficient = 1.879e-4 / (4 * kPi * kPi);
    r.drag_ratio = 0.0165;
    r.bidirectional = true;
    r.min_thrust = 0.15;
    r.max_thrust = max_thrust;
    r.radius = 0.0635;
    v.rotors.push_back(r);
  }
  return v;
}

}  // namespace omniflight::allocation
