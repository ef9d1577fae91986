#include "noise_spectrum.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "omniflight_core/frames.hpp"
#include "told_noise.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kUpdates = 60;  ///< multiplicative updates of a spectrum; the likelihood is flat by then
/// Corner frequencies [Hz] of the first-order parts: correlation times of 3 s to 25 ms.
constexpr std::array<double, 8> kCorners{0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4};
constexpr double kReference = 5;  ///< Hz, at which the rising parts are one
/// Hz, below which the correction runs over frequency, above over its logarithm.
constexpr double kKnee = 0.2;
constexpr double kCorrection = 0.5;  ///< prior standard deviation of a term of the correction
constexpr int kScoring = 12;         ///< Fisher scoring converges in some
/// Prior standard deviations [ln of density] of factors on told turbulence and on the told noise of sensors,
/// of a term that the channels of a force or torque share, and of one of a channel's own. Chosen: in nominal
/// synthetic flights channels deviate by some 0.1 from what they share, which a wrong correlation time, or
/// turbulence of another order, takes to 1.
constexpr double kTurbulence = 0.7, kSensors = 0.7, kShape = 0.5, kOwn = 0.15;

}  // namespace

Eigen::MatrixXd NoiseSpectrum::parts(const Eigen::ArrayXd& f) {
  const Eigen::ArrayXd square = f.square(), r = square / (kReference * kReference);
  Eigen::MatrixXd out(f.size(), kParts);
  for (std::size_t k = 0; k < kCorners.size(); ++k)
    out.col(static_cast<Eigen::Index>(k)) = 1 / (1 + square / (kCorners[k] * kCorners[k]));
  out.col(8).setOnes();
  out.col(9) = r;
  out.col(10) = r.square();
  out.col(11) = r.cube();  // what block means leave of a pose that is differentiated twice
  return out;
}

void NoiseSpectrum::fit(const PowerBands& bands, bool corrected) {
  const auto& [f, power, freedom] = bands;
  const double mean = freedom.sum() > 0 ? power.sum() / freedom.sum() : 0.0;
  silent_ = !(mean > 0) || !std::isfinite(mean);
  if (silent_) return;
  const Eigen::MatrixXd B = parts(f);
  weight_.setConstant(mean / kParts);
  for (int pass = 0; pass < kUpdates; ++pass) {
    const Eigen::ArrayXd S = (B * weight_).array().max(1e-9 * mean);
    const Eigen::VectorXd up = B.transpose() * (power.array() / S.square()).matrix();
    const Eigen::VectorXd down = B.transpose() * (freedom.array() / S).matrix();
    weight_.array() *= (up.array() / down.array().max(1e-300)).sqrt();
  }
  if (corrected) correct(bands);
}

Eigen::MatrixXd NoiseSpectrum::terms(const Eigen::ArrayXd& f) const {
  const Eigen::ArrayXd place = (f.min(highest_) / kKnee).log1p() / std::log1p(highest_ / kKnee);
  const Eigen::ArrayXd first = (kPi * place).cos();
  Eigen::MatrixXd out(f.size(), kTerms);
  out.col(0).setOnes();
  out.col(1) = first;
  for (int k = 2; k < kTerms; ++k)  // cosines of multiples (Chebyshev)
    out.col(k) = (2 * first * out.col(k - 1).array() - out.col(k - 2).array()).matrix();
  return out;
}

/// Penalised Whittle likelihood by Fisher scoring.
void NoiseSpectrum::correct(const PowerBands& bands) {
  const auto& [f, power, freedom] = bands;
  highest_ = f.maxCoeff();
  if (!(highest_ > 0)) return;
  const Eigen::MatrixXd B = terms(f);
  const Eigen::ArrayXd ratio = power.array() / (parts(f) * weight_).array().max(1e-300);
  Eigen::MatrixXd information =
      0.5 * B.transpose() * freedom.asDiagonal() * B;  // of amplitudes, which have one degree of freedom
  information.diagonal().array() += 1 / (kCorrection * kCorrection);
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(kTerms);
  for (int pass = 0; pass < kScoring; ++pass) {
    const Eigen::VectorXd surplus = (ratio * (-(B * c).array()).exp() - freedom.array()).matrix();
    const Eigen::VectorXd gradient = 0.5 * B.transpose() * surplus - c / (kCorrection * kCorrection);
    Eigen::VectorXd step = factor.solve(gradient);
    step *= std::min(1.0, 1.0 / std::max(1e-12, step.cwiseAbs().maxCoeff()));
    c += step;
  }
  if (c.allFinite()) correction_ = c;
}

Eigen::ArrayXd NoiseSpectrum::densities(const Eigen::ArrayXd& f) const {
  const Eigen::ArrayXd smooth = scale_ * (terms(f) * correction_).array().exp();
  if (!told_) return (parts(f) * weight_).array() * smooth;
  return (std::exp(log_turbulence_) * told_->turbulence(f) + std::exp(log_sensors_) * told_->sensors(f)) *
         smooth;
}

Eigen::VectorXd NoiseSpectrum::inverse_deviations(int size, double period_s) const {
  return densities(Eigen::ArrayXd::LinSpaced(size, 0, size - 1) * (0.5 / (size * period_s))).rsqrt();
}

double NoiseSpectrum::fit_told(std::span<const std::shared_ptr<const ToldSpectrum>, 3> told,
                               std::span<const PowerBands, 3> bands, ToldShape shape, double temperature,
                               std::span<NoiseSpectrum, 3> out) {
  constexpr Eigen::Index kShared = 2 + kTerms;
  const bool own = shape == ToldShape::corrected;
  const Eigen::Index count = own ? kShared + 3 * kTerms : 2;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(count), deviation = Eigen::VectorXd::Constant(count, kOwn);
  deviation.head<2>() << kTurbulence, kSensors;
  if (own) deviation.segment<kTerms>(2).setConstant(kShape);
  std::array<Eigen::ArrayXd, 3> turbulence, sensors;
  std::array<Eigen::MatrixXd, 3> B;
  for (std::size_t k = 0; k < 3; ++k) {
    NoiseSpectrum& s = out[k];
    s.silent_ = false;
    s.told_ = told[k];
    s.highest_ = bands[k].frequency.maxCoeff();
    turbulence[k] = told[k]->turbulence(bands[k].frequency);
    sensors[k] = told[k]->sensors(bands[k].frequency);
    B[k] = s.terms(bands[k].frequency);
  }
  for (int pass = 0; pass < kScoring; ++pass) {
    Eigen::MatrixXd H = deviation.array().square().inverse().matrix().asDiagonal();
    Eigen::VectorXd g = -x.array() / deviation.array().square();
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Index at = kShared + static_cast<Eigen::Index>(k) * kTerms;
      const Eigen::ArrayXd t = std::exp(x[0]) * turbulence[k], s = std::exp(x[1]) * sensors[k];
      Eigen::ArrayXd S = t + s;
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(S.size(), count);
      J.col(0) = t / S;
      J.col(1) = s / S;
      if (own) {
        J.middleCols<kTerms>(2) = J.middleCols<kTerms>(at) = B[k];
        S *= (B[k] * (x.segment<kTerms>(2) + x.segment<kTerms>(at))).array().exp();
      }
      const Eigen::VectorXd surplus = bands[k].power.array() / S - bands[k].freedom.array();
      H.noalias() += 0.5 / temperature * J.transpose() * bands[k].freedom.asDiagonal() * J;
      g.noalias() += 0.5 / temperature * J.transpose() * surplus;
    }
    Eigen::VectorXd step = H.llt().solve(g);
    step *= std::min(1.0, 1.0 / std::max(1e-12, step.cwiseAbs().maxCoeff()));
    x += step;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    out[k].log_turbulence_ = x[0];
    out[k].log_sensors_ = x[1];
    if (own)
      out[k].correction_ =
          x.segment<kTerms>(2) + x.segment<kTerms>(kShared + static_cast<Eigen::Index>(k) * kTerms);
  }
  return -0.5 * (x.array() / deviation.array()).square().sum();
}

}  // namespace omniflight::diagnosis
