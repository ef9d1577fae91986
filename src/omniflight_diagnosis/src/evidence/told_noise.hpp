// The spectrum that the noise of the wrench residual has where turbulence and sensors are as they are told.
#pragma once

#include "noise_model.hpp"

namespace omniflight::diagnosis {

/// Power spectral density of one channel of one flight, of its two parts.
class ToldSpectrum {
 public:
  /// Turbulence of this RMS and correlation time [s] (Ornstein-Uhlenbeck), blurred by a normal kernel of
  /// kernel_s [s] and sampled every period_s [s]; noise of the sensors by its smoothed spectrum.
  ToldSpectrum(double turbulence_rms, double correlation_time, double kernel_s, double period_s,
               NoiseSpectrum sensors);
  Eigen::ArrayXd turbulence(const Eigen::ArrayXd& frequency_hz) const;
  Eigen::ArrayXd sensors(const Eigen::ArrayXd& frequency_hz) const {
    return sensors_.densities(frequency_hz);
  }

 private:
  double variance_, correlation_time_, kernel_s_, period_s_;
  NoiseSpectrum sensors_;
};

ToldSpectra told_spectra(const RegressionProblem& problem);

}  // namespace omniflight::diagnosis
