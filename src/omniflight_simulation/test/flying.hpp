// What the tests of this package share: a vehicle, a model, a plant.
#pragma once

#include <cstdlib>
#include <stdexcept>

#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation {

inline vehicle::Vehicle omnimorph() {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle("omnimorph");
  if (!v) throw std::runtime_error(v.error().text());
  return *v;
}

inline Plant make(const vehicle::Vehicle& v, const physics::Model& m, const PlantConfig& c) {
  auto p = Plant::create(v, m, c);
  if (!p) throw std::runtime_error(p.error().text());
  return *p;
}

/// Speed [rad/s] of every rotor that carries the vehicle at a tilt [rad].
inline std::vector<double> hover_speed(const vehicle::Vehicle& v, double alpha) {
  const double each = v.mass * kGravity / (static_cast<double>(v.rotors.size()) * std::cos(alpha));
  return std::vector<double>(v.rotors.size(), v.rotors[0].speed(each));
}

}  // namespace omniflight::simulation
