// Noise from what slow functions of place leave: fitted to the residual itself it would take slow effects for
// noise, in which they are then no longer found.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "../search/hypothesis.hpp"

namespace omniflight::diagnosis {

/// Columns that are mostly functions of one channel alone: cosine amplitudes of each channel, of those that
/// are not zero in it.
struct SlowColumns {
  struct Channel {
    std::vector<Eigen::Index> rows;     ///< of these amplitudes among those of all channels
    std::vector<Eigen::Index> columns;  ///< among all
    Eigen::MatrixXd amplitudes;         ///< rows x columns
    Eigen::ArrayXd power;               ///< sum of squares of each row
  };
  std::array<Channel, 6> channels;
  ToldSpectra told;        ///< of the noise that is left of them
  Eigen::Index count = 0;  ///< of columns
};

/// Constant forces and torques, and smooth functions of place and rotor tilt.
/// What the rotors and the rates do is not among them: through feedback they follow the disturbance, and a
/// regression on them would take noise away.
SlowColumns slow_columns(const RegressionProblem& problem);

/// Whether lone samples may have more than noise. What a set leaves before it was fitted has steps and peaks
/// that are no blows: taken off, they would not speak for a better fit any more.
enum class LoneSamples { none, sought };

/// Noise of the residual less `known` (what a fitted set does, or zero) and less a ridge regression on
/// `slow`.
std::unique_ptr<NoiseModel> estimate_noise(const RegressionProblem& problem, const SlowColumns& slow,
                                           const Eigen::VectorXd& known, double temperature,
                                           ToldShape shape = ToldShape::corrected,
                                           LoneSamples lone = LoneSamples::none);

}  // namespace omniflight::diagnosis
