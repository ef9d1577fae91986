// Noise of the wrench residual: turbulence and sensor noise, whose spectrum falls or rises without
// resonances.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "../regression/regression_problem.hpp"
#include "cosine_transform.hpp"
#include "noise_spectrum.hpp"

namespace omniflight::diagnosis {

/// How many cosine amplitudes a column has.
Eigen::Index amplitude_count(const RegressionProblem& problem);

/// Cosine amplitudes of columns, of every channel of every stretch: what no noise changes of whitening. Rows:
/// of each stretch channel by channel, as many as transform_length() says.
Eigen::MatrixXd cosine_amplitudes(const RegressionProblem& problem,
                                  const Eigen::Ref<const Eigen::MatrixXd>& columns);

/// Samples of cosine amplitudes: cosine_amplitudes() undone, zero behind the transform of a stretch. All
/// rows.
Eigen::VectorXd samples_of(const RegressionProblem& problem, Eigen::VectorXd amplitudes);

/// Of each channel of each flight; empty where nothing is told.
using ToldSpectra = std::vector<std::array<std::shared_ptr<const ToldSpectrum>, 6>>;

/// Lone samples that have more than noise of a spectrum.
struct Impulses {
  Eigen::VectorXd sizes;   ///< N and Nm in one sample, all rows, mostly zero; empty where nobody looked
  Eigen::VectorXd wrench;  ///< the same as the signals are smoothed, all rows
  int count = 0;
  double log_prior = 0;  ///< ln density of their prior over that of none
};

class NoiseModel {
 public:
  /// Fitted to the cosine amplitudes `rest` of what a regression left of the residual, with `freedom` of each
  /// (1: nothing was fitted, 0: all of it). `temperature` divides all log-likelihoods (1: as they are).
  /// Channels with a told spectrum are fitted about it. `impulses`: what lone samples have beside it, which
  /// is no part of a residual that is whitened.
  NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest, const Eigen::VectorXd& freedom,
             double temperature, const ToldSpectra& told = {}, ToldShape shape = ToldShape::corrected,
             Impulses impulses = {});
  NoiseModel(const NoiseModel&) = delete;
  NoiseModel& operator=(const NoiseModel&) = delete;

  /// Rows at the end of whitened columns, zero: observations that are none of the residual, see Evidence.
  static constexpr Eigen::Index kBeside = 6;

  /// Whitened columns: cosine amplitudes of each stretch and channel over their standard deviations. Rows:
  /// whitened_rows().
  Eigen::MatrixXd apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;
  /// The same of their cosine amplitudes.
  template <class Matrix>
  Eigen::MatrixXd scale(const Matrix& amplitudes) const {
    Eigen::MatrixXd out(rows_, amplitudes.cols());
    for (const Block& b : blocks_)
      out.middleRows(b.row, b.size) =
          b.inverse.asDiagonal() * amplitudes.middleRows(b.amplitude, b.size).template cast<double>();
    out.bottomRows(kBeside).setZero();
    return out;
  }
  Eigen::Index whitened_rows() const { return rows_; }
  /// A column (all rows) times the inverse covariance of the noise: its product with another column is that
  /// of both whitened.
  Eigen::VectorXd weigh(const Eigen::VectorXd& column) const;
  /// The residual of the problem less the impulses. N and Nm, all rows.
  Eigen::VectorXd residual() const;
  /// What a set that leaves `after` gains on one that leaves `before` [nat, of log-likelihood] in the noise
  /// that it leaves itself, beyond what it gains in this noise: noise that contains an effect hides it. By
  /// the power in octaves, without an estimate of that noise.
  double gain_of_own_noise(const Eigen::VectorXd& before, const Eigen::VectorXd& after) const;
  /// One over the standard deviation of each cosine amplitude; 0 where a channel has no noise.
  Eigen::VectorXd inverse_deviations() const;
  /// Standard deviation of the noise of a channel above half of the highest frequency, mean over flights:
  /// what a sample does not tell of the next.
  double fast_part(int channel) const;
  /// Sum of ln of the standard deviations: subtracted from evidences it makes those in different noise
  /// comparable.
  double log_scale() const { return log_scale_; }
  /// ln density of the prior of these spectra over its mode (0 where nothing is told), and of the impulses.
  double log_prior() const { return log_prior_ + impulses_.log_prior; }
  const Impulses& impulses() const { return impulses_; }
  /// Of a channel of a flight, temperature included.
  const NoiseSpectrum& spectrum(int flight, int channel) const {
    return spectra_[static_cast<std::size_t>(flight)][static_cast<std::size_t>(channel)];
  }

 private:
  struct Block {  ///< one channel of one stretch
    int size = 0;
    Eigen::Index row = 0;        ///< first of its whitened rows
    Eigen::Index amplitude = 0;  ///< first of its cosine amplitudes
    Eigen::VectorXd inverse;     ///< one over the standard deviation of each amplitude
    int spectrum = 0;            ///< flight and channel
    double frequency_step = 0;   ///< Hz
  };
  const RegressionProblem& problem_;
  std::vector<std::array<NoiseSpectrum, 6>> spectra_;
  std::vector<Block> blocks_;
  Eigen::Index rows_ = kBeside, amplitudes_ = 0;
  double temperature_ = 1;
  double log_scale_ = 0, log_prior_ = 0;
  Impulses impulses_;
};

}  // namespace omniflight::diagnosis
