#include "noise_model.hpp"

#include <algorithm>
#include <cmath>
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
constexpr int kScoring = 12;         ///< Fisher scoring converges in some

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

void NoiseSpectrum::fit(const Eigen::VectorXd& f, const Eigen::VectorXd& power) {
  const double mean = power.size() > 0 ? power.mean() : 0.0;
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
    const Eigen::VectorXd down = B.transpose() * S.inverse().matrix();
    w.array() *= (up.array() / down.array().max(1e-300)).sqrt();
  }
  for (std::size_t k = 0; k < kParts; ++k) weight_[k] = w[static_cast<Eigen::Index>(k)];
  correct(f, power);
}

std::array<double, NoiseSpectrum::kTerms> NoiseSpectrum::terms(double f) const {
  const double place = std::log1p(std::min(f, highest_) / kKnee) / std::log1p(highest_ / kKnee);
  std::array<double, kTerms> out{};
  for (std::size_t k = 0; k < kTerms; ++k) out[k] = std::cos(static_cast<double>(k) * kPi * place);
  return out;
}

/// Penalised Whittle likelihood by Fisher scoring.
void NoiseSpectrum::correct(const Eigen::VectorXd& f, const Eigen::VectorXd& power) {
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
  Eigen::MatrixXd information = 0.5 * B.transpose() * B;  // of amplitudes, which have one degree of freedom
  information.diagonal().array() += 1 / (kCorrection * kCorrection);
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(terms_count);
  for (int pass = 0; pass < kScoring; ++pass) {
    const Eigen::VectorXd surplus = (ratio * (-(B * c).array()).exp() - 1).matrix();
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

NoiseModel::NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest, int parameters,
                       double temperature)
    : problem_(problem), spectra_(static_cast<std::size_t>(problem.flights())) {
  const int n = problem.samples();
  const double rate = 1 / problem.period();
  // what the fitted parameters took from the noise
  const double inflation = 1.0 / std::max(0.5, 1.0 - parameters / (6.0 * std::max(1, n)));
  for (int flight = 0; flight < problem.flights(); ++flight)
    for (int c = 0; c < 6; ++c) {
      std::vector<double> frequency, power;
      for (const Stretch& s : problem.stretches()) {
        if (s.flight != flight) continue;
        const int size = transform_length(s.size());
        Eigen::VectorXd x = rest.segment(c * n + s.begin, size);
        if (x.norm() < 1e-9 * problem.scale(c)) continue;
        CosineTransform(size).apply(x);
        for (int k = 0; k < size; ++k) {
          frequency.push_back(0.5 * rate * k / size);
          power.push_back(x[k] * x[k]);
        }
      }
      NoiseSpectrum& spectrum = spectra_[static_cast<std::size_t>(flight)][static_cast<std::size_t>(c)];
      spectrum.fit(Eigen::Map<Eigen::VectorXd>(frequency.data(), static_cast<Eigen::Index>(frequency.size())),
                   Eigen::Map<Eigen::VectorXd>(power.data(), static_cast<Eigen::Index>(power.size())));
      spectrum.scale(inflation * std::max(1e-3, temperature));
    }
  Eigen::Index amplitude = 0;
  for (const Stretch& s : problem.stretches())
    for (int c = 0; c < 6; ++c) {
      const NoiseSpectrum& spectrum =
          spectra_[static_cast<std::size_t>(s.flight)][static_cast<std::size_t>(c)];
      Block b;
      b.size = transform_length(s.size());
      b.row = rows_;
      b.amplitude = amplitude;
      amplitude += b.size;
      if (spectrum.silent()) continue;
      b.inverse.resize(b.size);
      for (int k = 0; k < b.size; ++k)
        b.inverse[k] = 1 / std::sqrt(spectrum.density(0.5 * rate * k / b.size));
      log_scale_ -= b.inverse.array().log().sum();
      rows_ += b.size;
      blocks_.push_back(std::move(b));
    }
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

double NoiseModel::fast_part(int channel) const {
  const double highest = 0.5 / problem_.period();
  double sum = 0;
  for (const auto& flight : spectra_)
    sum += std::sqrt(flight[static_cast<std::size_t>(channel)].density(0.75 * highest));
  return spectra_.empty() ? 0.0 : sum / static_cast<double>(spectra_.size());
}

}  // namespace omniflight::diagnosis
