// What several tests share: the committed test bed and the shipped vehicle.
#pragma once

#include <filesystem>

#include "omniflight_planning/map.hpp"
#include "omniflight_planning/state_check.hpp"
#include "omniflight_planning/test_bed.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

inline const std::filesystem::path kConfigs = std::filesystem::path(OMNIFLIGHT_SOURCE_ROOT) / "configs";

inline vehicle::Vehicle omnimorph() {
  return vehicle::load_vehicle((kConfigs / "vehicles/omnimorph/omnimorph.yaml").string()).value();
}
inline const DistanceMap& pyramid() {
  static const DistanceMap map = DistanceMap::load(kConfigs / "test_beds/pyramid.bt").value();
  return map;
}
inline allocation::RotorLoad rotor_load(const vehicle::Vehicle& v, double alpha) {
  return allocation::RotorLoad::create(v, alpha).value();
}
inline StateCheck make_check(const DistanceMap& map, double alpha_deg, double margin) {
  const auto v = omnimorph();
  const double alpha = to_radians(alpha_deg);
  auto rotors = std::make_shared<const allocation::RotorLoad>(rotor_load(v, alpha));
  return {map, cover_with_spheres(v, alpha), std::move(rotors), 0.05, margin};
}

}  // namespace omniflight::planning
