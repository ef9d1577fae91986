// Posterior over effects of the rotor drives, from commands and measured speeds.
#pragma once

#include <string>
#include <vector>

#include "drive_model.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

/// One set of effects at its maximum a posteriori.
struct DriveFit {
  DriveSet set;
  double log_evidence = 0;    ///< up to a constant that all sets share
  Eigen::MatrixXd precision;  ///< posterior precision of the coordinates

  double log_joint() const;            ///< ln evidence plus ln prior odds of the members
  Eigen::MatrixXd covariance() const;  ///< posterior, standardised coordinates
};

struct DriveInference {
  std::vector<DriveFit> fits;  ///< most probable first
  std::vector<const physics::Effect*> asked;
  double rms_nominal = 0, rms_left = 0;  ///< rad/s, RMS residual without effects, and of the best set
  double offset_s = 0;                   ///< estimated offset of the time stamps in the best set
  double offset_deviation_s = 0;         ///< its posterior standard deviation
  bool empty() const { return fits.empty(); }
};

/// Inference over all effects that act on the drives only, in sets of up to three. flights[k] is
/// recordings[k] after conditioning. Empty where no flight has commands and speeds, no rotor turns, or
/// Options::stop returns true.
DriveInference infer_drives(const std::vector<const recording::Recording*>& recordings,
                            const std::vector<const Flight*>& flights, const vehicle::Vehicle& vehicle,
                            const Options& options);

/// Note on a delay common to all motor controllers, which may be one of time stamps; empty if it is not
/// significant.
std::string on_shared_delay(const DriveInference& inference);

/// Adds members of the best set as findings with mismatches and model effects, and a decision for every
/// effect.
void add_drives(const DriveInference& inference, const vehicle::Vehicle& vehicle, const Options& options,
                Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
