// Power spectral density of the noise of one channel: of any size, or about as it is told.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <span>

namespace omniflight::diagnosis {

class ToldSpectrum;

/// Sums over the cosine amplitudes of one channel of a flight that are of about one frequency.
struct PowerBands {
  Eigen::VectorXd frequency;  ///< Hz
  Eigen::VectorXd power;      ///< of their squares
  Eigen::VectorXd freedom;    ///< degrees of freedom that a regression left to them
};

/// Whether a told spectrum is only scaled, or also bent.
enum class ToldShape { as_told, corrected };

/// Power spectral density of one channel of one flight. Where nothing is told, a sum of non-negative parts:
/// first-order (Ornstein-Uhlenbeck) processes of several corner frequencies, white noise, and white noise
/// differentiated once, twice and three times; times the exponential of a smooth function of log frequency
/// (Bloomfield 1973), for turbulence of a higher order and for what averaging leaves of sensor noise. An
/// autoregression would also describe a load that swings, and take it for noise; the smooth function is wider
/// than that.
class NoiseSpectrum {
 public:
  static constexpr int kParts = 12;
  static constexpr int kTerms = 5;

  /// Maximises Whittle's likelihood of the amplitudes (restricted, Patterson and Thompson 1971) by
  /// multiplicative updates, which keep the parts non-negative. `corrected`: and then of the smooth function.
  void fit(const PowerBands& bands, bool corrected = true);
  /// Spectra of the three channels of a force or torque that are about as told, at the mode of their
  /// posterior with Whittle's likelihood to the power 1/temperature. Deviations of the told spectrum are
  /// normal in its logarithm: factors on turbulence and on the noise of the sensors and, where `shape` is
  /// corrected, smooth functions of log frequency, one that the channels share and one of each. Returns ln of
  /// the prior's density there over its maximum.
  static double fit_told(std::span<const std::shared_ptr<const ToldSpectrum>, 3> told,
                         std::span<const PowerBands, 3> bands, ToldShape shape, double temperature,
                         std::span<NoiseSpectrum, 3> out);
  Eigen::ArrayXd densities(const Eigen::ArrayXd& frequency_hz) const;
  /// One over the standard deviations of the cosine amplitudes of `size` samples that are period_s apart.
  Eigen::VectorXd inverse_deviations(int size, double period_s) const;
  bool silent() const { return silent_; }
  void scale(double factor) { scale_ *= factor; }

 private:
  static Eigen::MatrixXd parts(const Eigen::ArrayXd& frequency_hz);  ///< frequencies x kParts
  Eigen::MatrixXd terms(const Eigen::ArrayXd& frequency_hz) const;   ///< frequencies x kTerms
  void correct(const PowerBands& bands);
  std::shared_ptr<const ToldSpectrum> told_;     ///< instead of the parts
  double log_turbulence_ = 0, log_sensors_ = 0;  ///< factors of what is told
  Eigen::Vector<double, kParts> weight_ = Eigen::Vector<double, kParts>::Zero();
  /// Of ln density, cosines of log frequency.
  Eigen::Vector<double, kTerms> correction_ = Eigen::Vector<double, kTerms>::Zero();
  double scale_ = 1;
  double highest_ = 1;  ///< Hz, where the last half wave ends
  bool silent_ = true;
};

}  // namespace omniflight::diagnosis
