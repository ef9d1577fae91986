// How a world can differ from the nominal one: a named mechanism with one amplitude, which is turned until
// the effect has the wanted size.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "case_flight.hpp"
#include "case_truth.hpp"

namespace omniflight::proof {

/// What is drawn besides the amplitude: directions, rotors, lengths. Numbers in [0, 1) of the chosen box.
struct Shape {
  std::array<double, 8> u{};
  double between(int k, double low, double high) const {
    return low + (high - low) * u[static_cast<std::size_t>(k)];
  }
  int whole(int k, int first, int last) const {
    return first + static_cast<int>(u[static_cast<std::size_t>(k)] * (last - first + 1));
  }
  double sign(int k) const { return u[static_cast<std::size_t>(k)] < 0.5 ? -1.0 : 1.0; }
  /// Unit vector from u[k], u[k + 1]; flat: across the vertical.
  Vec3 direction(int k, bool flat = false) const;
};
/// Numbers of the tuning box and of the sealed one never meet: each takes every other eighth of [0, 1).
Shape draw_shape(Random& random, bool sealed);

struct Mechanism {
  enum class Measure {
    wrench,   ///< of the plant: what the motion needs beyond the nominal vehicle
    command,  ///< of the thrusts that commands and the nominal lag do not give
    control,  ///< of the demands that the told gains do not give
    formula   ///< size() says; sensors do not move the vehicle
  };
  std::string id, stage, realisation, level;
  double smallest = 0, typical = 0, largest = 0;  ///< of the amplitude, in its own unit
  Measure measure = Measure::wrench;
  bool combines = false;     ///< may be one of two or three at once
  bool needs_tilt = false;   ///< nothing without tilt motion: designed flight only
  bool articulated = false;  ///< slow to fly
  std::function<void(FlightSetup&, double, const Shape&)> apply = {};
  std::function<std::vector<TrueParameter>(double, const Shape&)> parameters = {};
  std::function<double(double, const Shape&, const Flown& nominal)> size =
      {};                                   ///< sigma, for Measure::formula
  std::vector<std::string> variables = {};  ///< of an unknown one
  std::vector<std::string> along = {};      ///< other effects that this realisation has as well
};

/// All of them, for this vehicle; order is fixed.
std::vector<Mechanism> mechanisms(const vehicle::Vehicle& vehicle);

/// Residual noise of every world of the proof.
inline constexpr double kForceNoise = 0.15;    ///< N RMS an axis
inline constexpr double kTorqueNoise = 0.010;  ///< N m RMS an axis
inline constexpr double kNoiseTime = 0.3;      ///< s
/// RMS over noise in the strongest of six channels.
double in_sigma(const std::array<double, 6>& wrench);

}  // namespace omniflight::proof
