// What may be left out of the model: an effect of the library, or physics outside it as a smooth function of
// one state variable.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "../evidence/noise_model.hpp"

namespace omniflight::diagnosis {

/// Smooth function of one variable in one channel: Gaussian process with a squared-exponential kernel, as
/// coefficients ~ N(0, 1) of radial basis functions; or, over time, cosine and sine of one frequency.
struct Pattern {
  int channel = 0;     ///< 0 to 5
  bool world = false;  ///< forces only: along the world's axes
  std::string variable, unit;
  double frequency_hz = 0;     ///< of what pulsates in time
  Eigen::MatrixXd raw;         ///< rows x basis functions, for a coefficient of one
  Eigen::MatrixXf amplitudes;  ///< their cosine amplitudes
  Eigen::MatrixXd whitened;
};

/// Values of the shape parameters at which a hypothesis is tried, with what its amplitudes do there.
struct ShapePoint {
  std::vector<double> theta;  ///< amplitudes at their neutral values
  /// Indices of parameters that columns belong to; none where one column is the whole wrench.
  std::vector<std::size_t> amplitude;
  Eigen::VectorXd first_stage;  ///< of the amplitudes' columns
  Eigen::MatrixXf amplitudes;   ///< cosine amplitudes of the columns before the first stage
  Eigen::MatrixXd columns;      ///< whitened; one standard deviation each: amplitudes, then initial states
};

struct Hypothesis {
  std::string id;  ///< effect id, or "unknown"
  const physics::Effect* effect = nullptr;
  std::shared_ptr<const Pattern> pattern;
  double log_odds = 0;  ///< prior, of being there as it is here
  /// ln of the number of frequencies of which it is the best: in log_odds, and a part of the evidence
  double log_choices = 0;
  std::vector<ShapePoint> points;     ///< of an effect
  Eigen::MatrixXd linear;             ///< whitened, for a unit of each parameter; of constant columns only
  Eigen::VectorXd first_stage;        ///< of these columns
  Eigen::MatrixXd linear_amplitudes;  ///< cosine amplitudes of these columns before the first stage

  bool is_linear() const { return linear_amplitudes.cols() > 0; }
};

/// Linear in its parameters and without memory: its columns never change.
bool has_constant_columns(const physics::Effect& effect);

/// All hypotheses that these flights could show. Columns are whitened by `noise`, in which their first stages
/// are taken once for all noises.
std::vector<Hypothesis> make_hypotheses(const RegressionProblem& problem, const NoiseModel& noise,
                                        const std::vector<const physics::Effect*>& effects,
                                        const Options& options);

/// Columns of all shapes anew, for accelerations that are expected otherwise now.
void prepare_again(const RegressionProblem& problem, const NoiseModel& noise, int threads,
                   std::vector<Hypothesis>& hypotheses);

/// What a fit needs of a hypothesis on the problem that it was made for: without the grid. Not whitened.
Hypothesis without_grid(const Hypothesis& hypothesis);
/// The same on other recordings or at other accelerations, whitened by this noise; a pattern keeps its
/// amplitudes.
Hypothesis without_grid(const Hypothesis& hypothesis, const RegressionProblem& problem,
                        const NoiseModel& noise);

/// Whitens the columns of hypotheses anew.
void whiten(const NoiseModel& noise, int threads, std::vector<Hypothesis>& hypotheses);

}  // namespace omniflight::diagnosis
