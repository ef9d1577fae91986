// What the flights of the proof ask for: smooth steps and sums of sines in position, attitude, tilt and in
// the null space of the rotors.
#pragma once

#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::proof {

/// Value with two derivatives.
struct Jet2 {
  double value = 0, rate = 0, acceleration = 0;
};

/// One coordinate over time: a start, quintic steps and sines inside an envelope.
struct Coordinate {
  struct Step {
    double at, duration, change;
  };
  struct Sine {
    double amplitude, frequency, phase;  ///< unit of the coordinate, Hz, rad
  };
  double start = 0;
  std::vector<Step> steps;
  std::vector<Sine> sines;
  double sines_from = 0, sines_until = 0, ramp = 3;  ///< s; sines fade in and out
  struct Calm {
    double from, until;  ///< s; sines are down to calm_share in between
  };
  std::vector<Calm> calms;  ///< in order, at least 2 calm_ramp apart
  double calm_share = 0.2, calm_ramp = 1.5;

  Jet2 at(double t) const;
};

struct Path {
  std::string name;
  double duration = 60;      ///< s of free flight
  Coordinate position[3];    ///< m, world
  Coordinate rotation[3];    ///< rad, rotation vector
  Coordinate alpha;          ///< rad
  Coordinate null_space[2];  ///< N, two patterns of thrusts that give no wrench

  Reference at(double t) const;
};

/// T1 of the thesis: hover and lateral steps of 0.3 m at one height, attitude and tilt.
Path path_t1();
/// T2: ascent in two stages, lateral step of 0.3 m with 20 degrees of pitch, and back.
Path path_t2();
/// Made for diagnosis: sines in all six directions, tilt dither, null-space excitation, stages of height.
/// `vigour` scales the sines; phases come from random.
Path path_designed(Random& random, double vigour = 1);

}  // namespace omniflight::proof
