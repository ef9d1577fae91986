// The gallery of effects: one flight each, side by side with the flight that has none of them.
#pragma once

#include "metrics.hpp"
#include "omniflight_physics/effect.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

/// The effect, or which one may have been meant.
Result<const physics::Effect*> known_effect(const std::string& id);

struct GalleryOptions {
  std::vector<std::string> only;  ///< ids; empty: all
  std::string mission = "trajectory_2";
  int jobs = 0;       ///< 0: as many as there are processors
  bool keep = false;  ///< the recordings
};

/// What a flight showed, on a common grid of times [s].
struct GalleryFlight {
  const physics::Effect* effect = nullptr;  ///< nullptr: the nominal flight
  std::string verdict, reason;
  std::vector<double> t;               ///< s
  Eigen::MatrixXd wrench;              ///< N, Nm, body: of the effect, as the plant applied it
  Eigen::MatrixXd rotor_speed;         ///< rad/s, signed, one column a rotor
  Eigen::MatrixXd position, attitude;  ///< m, deg: true pose less the reference, world and body axes
  Eigen::MatrixXd sensed;              ///< m: position that the sensors show less the true one, world axes
  std::vector<double> power;           ///< W, mechanical
  double mean_power = 0;               ///< W
  double position_rmse = 0, attitude_rmse = 0;  ///< m, deg
  double wall_s = 0;
};

/// Flies all, writes out/gallery.html, prints a table. Exit code 0 when the page is complete.
Result<int> fly_gallery(const GalleryOptions& options, const Common& common);

/// One self-contained page. The nominal flight first.
Status write_gallery(const std::vector<GalleryFlight>& flights, const std::string& mission,
                     const std::string& path);

}  // namespace omniflight::cli
