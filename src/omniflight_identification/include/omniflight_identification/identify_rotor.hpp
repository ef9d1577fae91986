// Everything that is asked about one rotor, in one call.
#pragma once

#include <optional>

#include "omniflight_identification/continuous.hpp"
#include "omniflight_identification/motor_dynamics.hpp"
#include "omniflight_identification/prbs.hpp"
#include "omniflight_identification/residual_tests.hpp"
#include "omniflight_identification/selection.hpp"

namespace omniflight::identification {

struct RotorOptions {
  Trend trend = Trend::line;  ///< of the sampled models; the motor's dynamics have an offset instead
  double transient_s = 0.25;  ///< s of each experiment that do not count
  double max_delay_s = 0.05;  ///< s
  int max_order = 3;
  std::function<bool()> stop;  ///< true ends every search
};

struct StructureResult {
  Structure structure = Structure::arx;
  Candidate candidate;
  std::optional<ContinuousEquivalent> continuous;
  ResidualTest whiteness, independence;  ///< on the validation data
};

struct RotorResult {
  MotorDynamics motor;
  double validation_percent = 0.0;  ///< of `motor`
  DelayEstimate delay;
  std::vector<StructureResult> structures;  ///< those that could be fitted, best on the validation data first
  std::vector<Error> failed;                ///< why others could not
  /// Residuals of the best structure against *later* commands: where they correlate, the command was made
  /// from the measured motion (closed loop).
  ResidualTest feedback;
  std::optional<WhitePart> prbs;  ///< of the first experiment, where its command is one
};

/// Estimation and validation data of one rotor, input 0 its command. Errors: check(); a PRBS whose bits are
/// so short that the motor does not follow (field, reason, next step); no structure could be fitted; stopped.
Result<RotorResult> identify_rotor(const Dataset& estimation, const Dataset& validation,
                                   const RotorOptions& options = {});

/// Names the bias of the direct method (Ljung 1999, section 13.4) for a result.
std::string closed_loop_words(const RotorResult& result);

}  // namespace omniflight::identification
