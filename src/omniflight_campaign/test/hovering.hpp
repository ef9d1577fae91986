// A hover that many flights share.
#pragma once

#include <cstdlib>

#include "omniflight_campaign/many_flights.hpp"

namespace omniflight::campaign {

/// Hover of `duration` s, with a push to one side in between so that there is a motion to look at.
inline Loop hovering(double duration = 6) {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  Loop loop;
  loop.vehicle = loop.believed = vehicle::load_vehicle("omnimorph").value();
  loop.allocator = allocation::AllocatorConfig::case_a();
  loop.allocator.tilt_mode = allocation::TiltMode::fixed;
  loop.allocator.initial_tilt = to_radians(30);
  loop.plant.initial_alpha = to_radians(30);
  loop.hold = 0.2;
  loop.settle = 1;
  std::vector<TrajectoryKnot> knots(2);
  knots[0].reference.p_WB = knots[1].reference.p_WB = Vec3(0, 0, 1.2);
  knots[0].reference.alpha = knots[1].reference.alpha = to_radians(30);
  knots[1].t = duration;
  loop.trajectory = Trajectory::create(knots).value();
  loop.duration = loop.hold + loop.settle + duration + 1;
  loop.plant.initial.p_WB = Vec3(0, 0, 1.2);
  return loop;
}

inline OneFlight one(const Loop& loop,
                     const std::vector<std::pair<std::string, std::vector<double>>>& effects = {}) {
  OneFlight f;
  f.start = loop.plant.initial;
  for (const auto& [id, theta] : effects) f.model.effects.push_back({physics::find_effect(id), theta});
  return f;
}

}  // namespace omniflight::campaign
