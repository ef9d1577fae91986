// Words for the lists of mechanisms.
#pragma once

#include <cmath>

#include "case_mechanism.hpp"

namespace omniflight::proof::words {

using Setup = FlightSetup;
using Measure = Mechanism::Measure;
using Parameters = std::vector<TrueParameter>;

inline TrueParameter scalar(const char* name, double value) { return {name, value, std::abs(value)}; }
inline Parameters vector(std::initializer_list<const char*> names, const Vec3& v) {
  Parameters out;
  int k = 0;
  for (const char* name : names) out.push_back({name, v[k++], v.norm()});
  return out;
}
inline Parameters nothing(double, const Shape&) { return {}; }

/// Rotor changes for those of a board (-1: all).
inline void each_rotor(Setup& s, const vehicle::Vehicle& vehicle, int board,
                       const std::function<void(RotorChange&)>& change) {
  for (int i = 0; i < vehicle.rotor_count(); ++i) {
    if (board >= 0 && vehicle.rotors[static_cast<std::size_t>(i)].board != board) continue;
    RotorChange c;
    c.rotor = i + 1;
    change(c);
    s.world.rotors.push_back(c);
  }
}
inline RotorChange one_rotor(const Shape& shape) {
  RotorChange c;
  c.rotor = shape.whole(0, 1, 8);
  return c;
}
inline Airframe& airframe(Setup& s) {
  if (!s.world.airframe) s.world.airframe.emplace();
  return *s.world.airframe;
}

}  // namespace omniflight::proof::words

namespace omniflight::proof {

// One list a file.
void hide_rigid_body(std::vector<Mechanism>& out, const vehicle::Vehicle& v);
void hide_actuation(std::vector<Mechanism>& out, const vehicle::Vehicle& v);
void hide_air(std::vector<Mechanism>& out);
void hide_tethers(std::vector<Mechanism>& out);
void hide_sensing(std::vector<Mechanism>& out, const vehicle::Vehicle& v);
void unknown_laws(std::vector<Mechanism>& out);  // case_unknown.cpp

}  // namespace omniflight::proof
