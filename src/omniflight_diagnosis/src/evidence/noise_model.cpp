#include "noise_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace omniflight::diagnosis {
namespace {

constexpr int kUpdates = 60;  ///< multiplicative updates of a spectrum; the likelihood is flat by then
/// Corner frequencies [Hz] of the first-order parts: correlation times of 3 s to 25 ms.
constexpr std::array<double, 8> kCorners{0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4};
constexpr double kReference = 5;  ///< Hz, at which the rising parts are one
/// Hz, below which the correction runs over frequency, above over its logarithm.
constexpr double kKnee = 0.2;
constexpr double kCorrection = 0.5;  ///< prior standard deviation of a term of the correction
constexpr int kOctaves = 9;          ///< in which the power of noise is compared
constexpr double kLowest = 0.08;     ///< Hz, end of the first
/// Of an amplitude that a regression explains whole: it tells nothing of the noise.
constexpr double kLeastFreedom = 0.02;
/// Amplitudes whose frequencies differ by less than this part are one to a spectrum, which is smooth; below
/// the floor [Hz] by this part of the floor.
constexpr double kBandWidth = 0.02, kBandFloor = 0.05;
constexpr int kScoring = 12;  ///< Fisher scoring converges in some

/// Sums over amplitudes of about one frequency.
struct Band {
  double count = 0, frequency = 0, power = 0, freedom = 0;
};

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

void NoiseSpectrum::fit(const Eigen::VectorXd& f, const Eigen::VectorXd& power,
                        const Eigen::VectorXd& freedom) {
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
  correct(f, power, freedom);
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
void NoiseSpectrum::correct(const Eigen::VectorXd& f, const Eigen::VectorXd& power,
                            const Eigen::VectorXd& freedom) {
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
  return (parts(f) * weight_).array() * (terms(f) * correction_).array().exp();
}

Eigen::VectorXd NoiseSpectrum::inverse_deviations(int size, double period_s) const {
  return densities(Eigen::ArrayXd::LinSpaced(size, 0, size - 1) * (0.5 / (size * period_s))).rsqrt();
}

NoiseModel::NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest,
                       const Eigen::VectorXd& freedom, double temperature)
    : problem_(problem),
      spectra_(static_cast<std::size_t>(problem.flights())),
      temperature_(std::max(1e-3, temperature)) {
  const double rate = 1 / problem.period();
  for (int flight = 0; flight < problem.flights(); ++flight)
    for (int c = 0; c < 6; ++c) {
      std::map<int, Band> bands;
      Eigen::Index amplitude = 0;
      for (const Stretch& s : problem.stretches()) {
        const int size = transform_length(s.size());
        const Eigen::Index first = amplitude + c * size;
        amplitude += 6 * size;
        if (s.flight != flight) continue;
        const auto x = rest.segment(first, size);
        if (x.norm() < 1e-9 * problem.scale(c)) continue;
        int number = -1;
        Band* band = nullptr;
        for (int k = 0; k < size; ++k) {
          const double frequency = 0.5 * rate * k / size;
          const int here = static_cast<int>(std::log1p(frequency / kBandFloor) / kBandWidth);
          if (here != number) band = &bands[number = here];
          band->count += 1;
          band->frequency += frequency;
          band->power += x[k] * x[k];
          band->freedom += std::max(kLeastFreedom, freedom[first + k]);
        }
      }
      NoiseSpectrum& spectrum = spectra_[static_cast<std::size_t>(flight)][static_cast<std::size_t>(c)];
      const auto count = static_cast<Eigen::Index>(bands.size());
      Eigen::VectorXd frequency(count), power(count), free(count);
      Eigen::Index at = 0;
      for (const auto& [number, band] : bands) {
        frequency[at] = band.frequency / band.count;
        power[at] = band.power;
        free[at++] = band.freedom;
      }
      spectrum.fit(frequency, power, free);
      spectrum.scale(temperature_);
    }
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    for (int c = 0; c < 6; ++c) {
      const NoiseSpectrum& spectrum =
          spectra_[static_cast<std::size_t>(s.flight)][static_cast<std::size_t>(c)];
      Block b;
      b.size = size;
      b.row = rows_;
      b.amplitude = amplitudes_;
      b.spectrum = 6 * s.flight + c;
      b.frequency_step = 0.5 * rate / size;
      amplitudes_ += size;
      if (spectrum.silent()) continue;
      b.inverse = spectrum.inverse_deviations(size, problem.period());
      log_scale_ -= b.inverse.array().log().sum();
      rows_ += size;
      blocks_.push_back(std::move(b));
    }
  }
}

double NoiseModel::gain_of_own_noise(const Eigen::VectorXd& before, const Eigen::VectorXd& after) const {
  struct Octave {
    double count = 0, before = 0, after = 0;
  };
  std::vector<std::array<Octave, kOctaves>> bands(6 * spectra_.size());
  for (const Block& b : blocks_)
    for (Eigen::Index k = 0; k < b.size; ++k) {
      const double octave = std::log2(std::max(1e-9, static_cast<double>(k) * b.frequency_step / kLowest));
      const auto at = static_cast<std::size_t>(std::clamp(octave, 0.0, kOctaves - 1.0));
      Octave& band = bands[static_cast<std::size_t>(b.spectrum)][at];
      band.count += 1;
      band.before += before[b.row + k] * before[b.row + k];
      band.after += after[b.row + k] * after[b.row + k];
    }
  double gain = 0;
  for (const auto& spectrum : bands)
    for (const Octave& b : spectrum)
      if (b.before > 0 && b.after > 0)
        gain += 0.5 * b.count * std::log(b.before / b.after) / temperature_ - 0.5 * (b.before - b.after);
  return gain;
}

Eigen::VectorXd NoiseModel::inverse_deviations() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(amplitudes_);
  for (const Block& b : blocks_) out.segment(b.amplitude, b.size) = b.inverse;
  return out;
}

Eigen::Index amplitude_count(const RegressionProblem& problem) {
  Eigen::Index out = 0;
  for (const Stretch& s : problem.stretches()) out += 6 * transform_length(s.size());
  return out;
}

Eigen::MatrixXd cosine_amplitudes(const RegressionProblem& problem,
                                  const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  const int n = problem.samples();
  Eigen::MatrixXd out(amplitude_count(problem), columns.cols());
  std::optional<CosineTransform> transform;
  int length = 0;
  Eigen::Index row = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    if (!transform || length != size) transform.emplace(length = size);
    for (int c = 0; c < 6; ++c, row += size) {
      Eigen::Index waiting = -1;  // a column that shares its transform with the next
      for (Eigen::Index col = 0; col < columns.cols(); ++col) {
        auto part = out.col(col).segment(row, size);
        part = columns.col(col).segment(c * n + s.begin, size);
        if (part.isZero(0)) continue;
        if (waiting < 0) {
          waiting = col;
          continue;
        }
        transform->apply(out.col(waiting).segment(row, size), part);
        waiting = -1;
      }
      if (waiting >= 0) transform->apply(out.col(waiting).segment(row, size));
    }
  }
  return out;
}

Eigen::MatrixXd NoiseModel::apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  return scale(cosine_amplitudes(problem_, columns));
}

Eigen::VectorXd NoiseModel::weigh(const Eigen::VectorXd& column) const {
  Eigen::VectorXd amplitudes = cosine_amplitudes(problem_, column);
  const Eigen::VectorXd inverse = inverse_deviations();
  amplitudes.array() *= inverse.array().square();
  Eigen::VectorXd out = Eigen::VectorXd::Zero(column.size());
  Eigen::Index row = 0;
  for (const Stretch& s : problem_.stretches()) {
    const int size = transform_length(s.size());
    CosineTransform transform(size);
    for (int c = 0; c < 6; ++c, row += size) {
      auto part = amplitudes.segment(row, size);
      transform.invert(part);
      out.segment(c * problem_.samples() + s.begin, size) = part;
    }
  }
  return out;
}

double NoiseModel::fast_part(int channel) const {
  const double highest = 0.5 / problem_.period();
  double sum = 0;
  for (const auto& flight : spectra_)
    sum += std::sqrt(
        flight[static_cast<std::size_t>(channel)].densities(Eigen::ArrayXd::Constant(1, 0.75 * highest))[0]);
  return spectra_.empty() ? 0.0 : sum / static_cast<double>(spectra_.size());
}

}  // namespace omniflight::diagnosis
