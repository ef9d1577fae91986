#include "noise_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "told_noise.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kOctaves = 9;       ///< in which the power of noise is compared
constexpr double kLowest = 0.08;  ///< Hz, end of the first
/// Of an amplitude that a regression explains whole: it tells nothing of the noise.
constexpr double kLeastFreedom = 0.02;
/// Amplitudes whose frequencies differ by less than this part are one to a spectrum, which is smooth; below
/// the floor [Hz] by this part of the floor.
constexpr double kBandWidth = 0.02, kBandFloor = 0.05;

/// Sums over amplitudes of about one frequency.
struct Band {
  double count = 0, frequency = 0, power = 0, freedom = 0;
};

PowerBands bands_of(const RegressionProblem& problem, const Eigen::VectorXd& rest,
                    const Eigen::VectorXd& freedom, int flight, int channel) {
  const double rate = 1 / problem.period();
  std::map<int, Band> bands;
  Eigen::Index amplitude = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    const Eigen::Index first = amplitude + channel * size;
    amplitude += 6 * size;
    if (s.flight != flight) continue;
    const auto x = rest.segment(first, size);
    if (x.norm() < 1e-9 * problem.scale(channel)) continue;
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
  const auto count = static_cast<Eigen::Index>(bands.size());
  PowerBands out{Eigen::VectorXd(count), Eigen::VectorXd(count), Eigen::VectorXd(count)};
  Eigen::Index at = 0;
  for (const auto& [number, band] : bands) {
    out.frequency[at] = band.frequency / band.count;
    out.power[at] = band.power;
    out.freedom[at++] = band.freedom;
  }
  return out;
}

/// Spectra of the three channels of a force or torque; returns ln density of their prior. `told`: empty where
/// nothing is told. `corrected`: by smooth functions of frequency.
double fit_spectra(std::span<const std::shared_ptr<const ToldSpectrum>> told,
                   std::span<const PowerBands, 3> bands, ToldShape shape, double temperature, bool corrected,
                   std::span<NoiseSpectrum, 3> out) {
  const bool noisy =
      std::all_of(bands.begin(), bands.end(), [](const PowerBands& b) { return b.power.sum() > 0; });
  if (noisy && !told.empty() && told.front()) {
    const double log_prior = NoiseSpectrum::fit_told(
        told.first<3>(), bands, corrected ? shape : ToldShape::as_told, temperature, out);
    if (std::isfinite(log_prior)) return log_prior;  // else numbers that no flight has
  }
  for (std::size_t k = 0; k < 3; ++k) (out[k] = NoiseSpectrum()).fit(bands[k], corrected);
  return 0;
}

}  // namespace

NoiseModel::NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest,
                       const Eigen::VectorXd& freedom, double temperature, const ToldSpectra& told,
                       ToldShape shape, Impulses impulses)
    : problem_(problem),
      spectra_(static_cast<std::size_t>(problem.flights())),
      temperature_(std::max(1e-3, temperature)),
      impulses_(std::move(impulses)) {
  const double rate = 1 / problem.period();
  for (int flight = 0; flight < problem.flights(); ++flight)
    for (const int first : {0, 3}) {
      std::array<PowerBands, 3> bands;
      for (int k = 0; k < 3; ++k)
        bands[static_cast<std::size_t>(k)] = bands_of(problem, rest, freedom, flight, first + k);
      const auto here = static_cast<std::size_t>(flight), at = static_cast<std::size_t>(first);
      const auto group = std::span(spectra_[here]).subspan(at).first<3>();
      std::span<const std::shared_ptr<const ToldSpectrum>> own;
      if (!told.empty()) own = std::span(told[here]).subspan(at);
      log_prior_ += fit_spectra(own, std::span(std::as_const(bands)), shape, temperature_,
                                problem.spectra_corrected(), group);
      for (NoiseSpectrum& s : group) s.scale(temperature_);
    }
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    for (int c = 0; c < 6; ++c) {
      const NoiseSpectrum& spectrum =
          spectra_[static_cast<std::size_t>(s.flight)][static_cast<std::size_t>(c)];
      Block b;
      b.size = size;
      b.row = rows_ - kBeside;
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

Eigen::VectorXd samples_of(const RegressionProblem& problem, Eigen::VectorXd amplitudes) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(problem.rows());
  Eigen::Index row = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    CosineTransform transform(size);
    for (int c = 0; c < 6; ++c, row += size) {
      auto part = amplitudes.segment(row, size);
      transform.invert(part);
      out.segment(c * problem.samples() + s.begin, size) = part;
    }
  }
  return out;
}

Eigen::MatrixXd NoiseModel::apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  return scale(cosine_amplitudes(problem_, columns));
}

Eigen::VectorXd NoiseModel::residual() const {
  return impulses_.count == 0 ? problem_.residual() : Eigen::VectorXd(problem_.residual() - impulses_.wrench);
}

Eigen::VectorXd NoiseModel::weigh(const Eigen::VectorXd& column) const {
  return samples_of(
      problem_, inverse_deviations().array().square() * cosine_amplitudes(problem_, column).col(0).array());
}

double NoiseModel::fast_part(int channel) const {
  const double highest = 0.5 / problem_.period();
  double sum = 0;
  for (const auto& flight : spectra_)
    sum += std::sqrt(
        flight[static_cast<std::size_t>(channel)].densities(Eigen::ArrayXd::Constant(1, 0.75 * highest))[0] /
        temperature_);
  return spectra_.empty() ? 0.0 : sum / static_cast<double>(spectra_.size());
}

}  // namespace omniflight::diagnosis
