#include "told_noise.hpp"

#include <cmath>

namespace omniflight::diagnosis {
namespace {

constexpr int kFolds = 2;  ///< of the spectrum at the sampling rate; the kernel leaves nothing beyond

}  // namespace

ToldSpectrum::ToldSpectrum(double turbulence_rms, double correlation_time, double kernel_s, double period_s,
                           NoiseSpectrum sensors)
    : variance_(turbulence_rms * turbulence_rms),
      correlation_time_(correlation_time),
      kernel_s_(kernel_s),
      period_s_(period_s),
      sensors_(std::move(sensors)) {}

Eigen::ArrayXd ToldSpectrum::turbulence(const Eigen::ArrayXd& f) const {
  Eigen::ArrayXd out = Eigen::ArrayXd::Zero(f.size());
  for (int fold = -kFolds; fold <= kFolds; ++fold) {
    const Eigen::ArrayXd omega = 2 * kPi * (f + fold / period_s_);
    out += (-(omega * kernel_s_).square()).exp() / (1 + (omega * correlation_time_).square());
  }
  return 2 * variance_ * correlation_time_ / period_s_ * out;
}

ToldSpectra told_spectra(const RegressionProblem& problem) {
  ToldSpectra out;
  if (!problem.noise_told()) return out;
  out.resize(static_cast<std::size_t>(problem.flights()));
  const Eigen::VectorXd amplitudes = cosine_amplitudes(problem, problem.sensor_noise());
  const NoiseModel sensors(problem, amplitudes, Eigen::VectorXd::Ones(amplitudes.size()), 1);
  const ToldNoise& told = problem.told_noise();
  for (int flight = 0; flight < problem.flights(); ++flight)
    for (int c = 0; c < (problem.forces_only() ? 3 : 6); ++c)
      out[static_cast<std::size_t>(flight)][static_cast<std::size_t>(c)] =
          std::make_shared<const ToldSpectrum>(c < 3 ? told.force : told.torque, told.correlation_time,
                                               problem.kernel(flight), problem.period(),
                                               sensors.spectrum(flight, c));
  return out;
}

}  // namespace omniflight::diagnosis
