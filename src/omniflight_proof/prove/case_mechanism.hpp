// How a world can differ from the nominal one: a named mechanism with one amplitude, which is turned until
// the effect has the wanted size.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "case_flight.hpp"
#include "case_shape.hpp"
#include "case_truth.hpp"

namespace omniflight::proof {

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
