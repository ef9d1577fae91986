// What the page shows: the vehicle in its place, and how it moves, as JSON.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "omniflight_planning/test_bed.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::view {

/// What does not move.
struct Scene {
  std::string title, subtitle;
  bool live = false;
  bool may_stop = false;  ///< the page shows an emergency stop
  vehicle::Vehicle vehicle;
  std::vector<planning::Primitive> solids;
};
/// Schema omniflight.view_scene/1: metres, newtons, rad/s.
std::string scene_json(const Scene& scene);

/// What is known of a flight at one instant; NaN and empty where it is not known.
struct Frame {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double t = 0;                          ///< s
  Vec3 p_WB = Vec3::Constant(kUnknown);  ///< m, world
  Quat q_WB = Quat::Identity();          ///< world <- body
  Vec3 p_WR = Vec3::Constant(kUnknown);  ///< m, reference
  double alpha = kUnknown;               ///< rad, tilt of the rotors
  std::vector<double> rotor_speed;       ///< rad/s, signed
  std::string failsafe, gate;            ///< their words
};
/// {"t", "p", "q", "ref", "alpha", "load", "power", "failsafe", "gate"}; load: thrust over the limit of each
/// rotor, power in W (mechanical).
std::string frame_json(const Frame& frame, const vehicle::Vehicle& vehicle);

/// A whole recording as columns, at `rate_hz` or slower so that there are at most `most` frames: schema
/// omniflight.view_replay/1. Errors: no pose in the recording.
Result<std::string> replay_json(const recording::Recording& recording, const vehicle::Vehicle& vehicle,
                                double rate_hz = 50, std::size_t most = 6000);

/// The path that is planned, as [[x, y, z], ...] in m; thinned to at most 2000 points.
std::string path_json(const std::vector<Vec3>& path);

}  // namespace omniflight::view
