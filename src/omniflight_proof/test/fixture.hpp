// A vehicle, a plant that hovers, and short ways to ask it.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "omniflight_proof/plant.hpp"

namespace omniflight::proof {

inline vehicle::Vehicle omnimorph() {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle("omnimorph");
  if (!v) {
    ADD_FAILURE() << v.error().text();
    std::abort();
  }
  return *v;
}

inline MujocoPlant make(const World& world, const RigidState& start = {.p_WB = Vec3(0, 0, 1.5)},
                        double alpha = 0) {
  static const vehicle::Vehicle v = omnimorph();
  auto plant = MujocoPlant::create(v, world, {.initial = start, .initial_alpha = alpha});
  if (!plant) {
    ADD_FAILURE() << plant.error().text();
    std::abort();
  }
  return std::move(*plant);
}

/// Speeds [rad/s] with which the nominal vehicle at tilt 0 carries `share` of its weight.
inline std::vector<double> hover_speeds(const vehicle::Vehicle& v, double share = 1) {
  std::vector<double> out;
  for (const auto& r : v.rotors) out.push_back(r.speed(share * v.mass * kGravity / v.rotor_count()));
  return out;
}

inline void run(MujocoPlant& plant, double seconds, bool held) {
  for (int k = 0; k < static_cast<int>(std::lround(seconds / plant.options().step)); ++k) {
    const auto ok = plant.step(held);
    ASSERT_TRUE(ok) << ok.error().text();
  }
}

/// Held until the rotors turn at hover speed, then released for one step.
inline MujocoPlant hovering(const World& world, const RigidState& start = {.p_WB = Vec3(0, 0, 1.5)}) {
  MujocoPlant plant = make(world, start);
  plant.set_command(hover_speeds(plant.vehicle()), 0);
  run(plant, 0.5, true);
  run(plant, 0.001, false);
  return plant;
}

inline void expect_near(const Vec3& a, const Vec3& b, double tolerance, const char* what = "") {
  EXPECT_LT((a - b).norm(), tolerance)
      << what << "\n  is     " << a.transpose() << "\n  wanted " << b.transpose();
}

}  // namespace omniflight::proof
