// What plausibility checks read off the rows of signals.
#pragma once

#include <initializer_list>
#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::diagnosis {

/// Euclidean norm of each sample.
inline std::vector<double> norms(const recording::Signal& s) {
  std::vector<double> out;
  for (Eigen::Index i = 0; i < s.size(); ++i) out.push_back(s.values.row(i).norm());
  return out;
}

/// The first of these that was recorded; nullptr when none was.
inline const recording::Signal* first_of(const recording::Recording& r,
                                         std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const recording::Signal* s = r.find(name)) return s;
  return nullptr;
}

/// Sum of the nominal thrusts [N, body] at a row of speeds [rad/s] and a tilt [rad]; NaN is taken as 0.
template <class Row>
Vec3 thrust_of(const vehicle::Vehicle& vehicle, const Row& speed, double tilt) {
  Vec3 f = Vec3::Zero();
  for (int k = 0; k < vehicle.rotor_count(); ++k)
    f += vehicle.rotors[static_cast<std::size_t>(k)].thrust(speed[k]) *
         vehicle.rotor_axis(k, std::isfinite(tilt) ? tilt : 0.0);
  return f;
}

}  // namespace omniflight::diagnosis
