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

std::array<double, NoiseSpectrum::kParts> NoiseSpectrum::parts(double f) {
  std::array<double, kParts> out{};
  for (std::size_t k = 0; k < kCorners.size(); ++k) out[k] = 1 / (1 + f * f / (kCorners[k] * kCorners[k]));
  const double r = f * f / (kReference * kReference);
  out[8] = 1;
  out[9] = r;
  out[10] = r * r;
  out[11] = r * r * r;  // what block means leave of a pose that is differentiated twice
  return out;
}

void NoiseSpectrum::fit(const Eigen::VectorXd& f, const Eigen::VectorXd& power,
                        const Eigen::VectorXd& freedom) {
  const double mean = freedom.sum() > 0 ? power.sum() / freedom.sum() : 0.0;
  silent_ = !(mean > 0) || !std::isfinite(mean);
  if (silent_) return;
  Eigen::MatrixXd B(f.size(), static_cast<Eigen::Index>(kParts));
  for (Eigen::Index i = 0; i < f.size(); ++i) {
    const auto p = parts(f[i]);
    for (std::size_t k = 0; k < kParts; ++k) B(i, static_cast<Eigen::Index>(k)) = p[k];
  }
  Eigen::VectorXd w = Eigen::VectorXd::Constant(B.cols(), mean / static_cast<double>(kParts));
  for (int pass = 0; pass < kUpdates; ++pass) {
    const Eigen::ArrayXd S = (B * w).array().max(1e-9 * mean);
    const Eigen::VectorXd up = B.transpose() * (power.array() / S.square()).matrix();
    const Eigen::VectorXd down = B.transpose() * (freedom.array() / S).matrix();
    w.array() *= (up.array() / down.array().max(1e-300)).sqrt();
  }
  for (std::size_t k = 0; k < kParts; ++k) weight_[k] = w[static_cast<Eigen::Index>(k)];
  correct(f, power, freedom);
}

std::array<double, NoiseSpectrum::kTerms> NoiseSpectrum::terms(double f) const {
  const double place = std::log1p(std::min(f, highest_) / kKnee) / std::log1p(highest_ / kKnee);
  std::array<double, kTerms> out{};
  for (std::size_t k = 0; k < kTerms; ++k) out[k] = std::cos(static_cast<double>(k) * kPi * place);
  return out;
}

/// Penalised Whittle likelihood by Fisher scoring.
void NoiseSpectrum::correct(const Eigen::VectorXd& f, const Eigen::VectorXd& power,
                            const Eigen::VectorXd& freedom) {
  highest_ = f.maxCoeff();
  if (!(highest_ > 0)) return;
  const auto terms_count = static_cast<Eigen::Index>(kTerms);
  Eigen::MatrixXd B(f.size(), terms_count);
  Eigen::ArrayXd ratio(f.size());
  for (Eigen::Index i = 0; i < f.size(); ++i) {
    const auto t = terms(f[i]);
    for (std::size_t k = 0; k < kTerms; ++k) B(i, static_cast<Eigen::Index>(k)) = t[k];
    ratio[i] = power[i] / std::max(1e-300, sum_of_parts(f[i]));
  }
  Eigen::MatrixXd information =
      0.5 * B.transpose() * freedom.asDiagonal() * B;  // of amplitudes, which have one degree of freedom
  information.diagonal().array() += 1 / (kCorrection * kCorrection);
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(terms_count);
  for (int pass = 0; pass < kScoring; ++pass) {
    const Eigen::VectorXd surplus = (ratio * (-(B * c).array()).exp() - freedom.array()).matrix();
    const Eigen::VectorXd gradient = 0.5 * B.transpose() * surplus - c / (kCorrection * kCorrection);
    Eigen::VectorXd step = factor.solve(gradient);
    step *= std::min(1.0, 1.0 / std::max(1e-12, step.cwiseAbs().maxCoeff()));
    c += step;
  }
  if (!c.allFinite()) return;
  for (std::size_t k = 0; k < kTerms; ++k) correction_[k] = c[static_cast<Eigen::Index>(k)];
}

double NoiseSpectrum::sum_of_parts(double f) const {
  const auto p = parts(f);
  double sum = 0;
  for (std::size_t k = 0; k < kParts; ++k) sum += weight_[k] * p[k];
  return sum;
}

double NoiseSpectrum::density(double f) const {
  const auto t = terms(f);
  double correction = 0;
  for (std::size_t k = 0; k < kTerms; ++k) correction += correction_[k] * t[k];
  return sum_of_parts(f) * std::exp(correction);
}

NoiseModel::NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest,
                       const Eigen::VectorXd& freedom, double temperature)
    : problem_(problem),
      spectra_(static_cast<std::size_t>(problem.flights())),
      temperature_(std::max(1e-3, temperature)) {
  const int n = problem.samples();
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
        Eigen::VectorXd x = rest.segment(c * n + s.begin, size);
        if (x.norm() < 1e-9 * problem.scale(c)) continue;
        CosineTransform(size).apply(x);
        for (int k = 0; k < size; ++k) {
          const double frequency = 0.5 * rate * k / size;
          Band& band = bands[static_cast<int>(std::log1p(frequency / kBandFloor) / kBandWidth)];
          band.count += 1;
          band.frequency += frequency;
          band.power += x[k] * x[k];
          band.freedom += std::max(kLeastFreedom, freedom[first + k]);
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
  for (const Stretch& s : problem.stretches())
    for (int c = 0; c < 6; ++c) {
      const NoiseSpectrum& spectrum =
          spectra_[static_cast<std::size_t>(s.flight)][static_cast<std::size_t>(c)];
      Block b;
      b.size = transform_length(s.size());
      b.row = rows_;
      b.amplitude = amplitudes_;
      b.spectrum = 6 * s.flight + c;
      b.frequency_step = 0.5 * rate / b.size;
      amplitudes_ += b.size;
      if (spectrum.silent()) continue;
      b.inverse.resize(b.size);
      for (int k = 0; k < b.size; ++k)
        b.inverse[k] = 1 / std::sqrt(spectrum.density(0.5 * rate * k / b.size));
      log_scale_ -= b.inverse.array().log().sum();
      rows_ += b.size;
      blocks_.push_back(std::move(b));
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

Eigen::MatrixXd cosine_amplitudes(const RegressionProblem& problem,
                                  const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  const int n = problem.samples();
  Eigen::Index rows = 0;
  for (const Stretch& s : problem.stretches()) rows += 6 * transform_length(s.size());
  Eigen::MatrixXd out(rows, columns.cols());
  std::optional<CosineTransform> transform;
  int length = 0;
  Eigen::Index row = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    if (!transform || length != size) transform.emplace(length = size);
    for (int c = 0; c < 6; ++c, row += size)
      for (Eigen::Index col = 0; col < columns.cols(); ++col) {
        auto part = out.col(col).segment(row, size);
        part = columns.col(col).segment(c * n + s.begin, size);
        if (!part.isZero(0)) transform->apply(part);
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
    sum += std::sqrt(flight[static_cast<std::size_t>(channel)].density(0.75 * highest));
  return spectra_.empty() ? 0.0 : sum / static_cast<double>(spectra_.size());
}

}  // namespace omniflight::diagnosis
