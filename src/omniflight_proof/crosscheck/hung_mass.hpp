// The articulated cable on a rail: what it weighs at each height, going down and up again.
#pragma once

#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_proof/plant.hpp"

namespace omniflight::proof {

struct HungMassOptions {
  std::vector<double> heights{1.6, 1.3, 1.0, 0.7, 0.5};  ///< m of the body origin, downward; then back up
  double speed = 0.2;                                    ///< m/s between them
  double pause = 1.2;                                    ///< s on each; the mean of the second half counts
};
struct HungMass {
  struct Rest {
    double height = 0;    ///< m, of the body origin
    double mass = 0;      ///< kg, mean weight over gravity
    double expected = 0;  ///< kg, linear density times height of the attachment over the floor
    bool upward = false;
  };
  std::vector<Rest> rests;
  std::vector<double> t, height, mass;  ///< s, m, kg: samples of the whole way at 100 Hz
  double simulated = 0;                 ///< s

  /// Largest difference between going down and going up, in bins of 5 cm of height, as a share of the largest
  /// mass of the law: how far the cable is from any law of the height alone.
  double hysteresis() const;
};

/// The vehicle is moved as on a rail; the world must have a cable. Errors: those of the plant.
Result<HungMass> measure_hung_mass(const vehicle::Vehicle& vehicle, const World& world,
                                   const HungMassOptions& options);

}  // namespace omniflight::proof
