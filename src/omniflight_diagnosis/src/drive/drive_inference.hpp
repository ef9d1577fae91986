// From commands and speeds of the rotors to the posterior over what alters their drives.
#pragma once

#include <string>
#include <vector>

#include "drive_model.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

struct DriveFit {
  DriveSet set;
  double log_evidence = 0;    ///< up to a constant that all sets share
  Eigen::MatrixXd precision;  ///< posterior precision of the coordinates

  double log_joint() const;  ///< ln evidence plus ln prior of its members
  Eigen::MatrixXd covariance() const;
};

struct DriveInference {
  std::vector<DriveFit> fits;  ///< the likeliest first
  std::vector<const physics::Effect*> asked;
  double rms_nominal = 0, rms_left = 0;  ///< rad/s: what no effect leaves, and what the best set does
  double offset_s = 0;                   ///< of the stamps, beside the best set
  double offset_deviation_s = 0;
  bool empty() const { return fits.empty(); }
};

/// Effects that the library says are seen in commands and speeds, and in nothing else, alone and together.
/// Empty where no flight has both, nothing turns, or the time is up. `flights` belong to `recordings`.
DriveInference infer_drives(const std::vector<const recording::Recording*>& recordings,
                            const std::vector<const Flight*>& flights, const vehicle::Vehicle& vehicle,
                            const Options& options);

/// What is said of a delay that all boards share and that may be one of stamps; empty if none is seen.
std::string on_shared_delay(const DriveInference& inference);

/// Members of the best set as findings, with their mismatch and the effects for the model; what became of
/// every other effect as a decision.
void add_drives(const DriveInference& inference, const vehicle::Vehicle& vehicle, const Options& options,
                Diagnosis& diagnosis);

}  // namespace omniflight::diagnosis
