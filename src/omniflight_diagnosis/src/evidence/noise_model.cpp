#include "noise_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cosine_transform.hpp"

namespace omniflight::diagnosis {
namespace {

/// All cosines are kept: under feedback the innovations are uncorrelated with predetermined regressors over
/// all frequencies together, and over no part of them alone.
constexpr int kSettle = 64;     ///< samples, the largest order in use
constexpr double kDegrees = 8;  ///< of freedom of the innovations' Student-t law
/// Upper edges of the bands [Hz]; the last one goes on to the end.
constexpr std::array<double, 7> kEdges{0.25, 0.5, 1, 2, 4, 8, 1e9};
/// Amplitudes at the autoregression's own level that are counted beside those of a band: a band of few
/// amplitudes has no variance of its own.
constexpr double kPseudoCount = 20;

std::size_t band_of(double frequency_hz) {
  std::size_t b = 0;
  while (frequency_hz > kEdges[b]) ++b;
  return b;
}

/// Burg's method over several stretches; the order is chosen by the corrected information criterion.
std::vector<double> burg(const std::vector<Eigen::VectorXd>& stretches, int max_order, double& sigma) {
  double n = 0, power = 0;
  for (const auto& x : stretches) {
    n += static_cast<double>(x.size());
    power += x.squaredNorm();
  }
  power /= std::max(1.0, n);
  sigma = std::sqrt(power);
  if (!(power > 0)) return {};
  std::vector<Eigen::VectorXd> f = stretches, b = stretches;
  std::vector<double> a, best;
  double best_score = n * std::log(power);
  for (int m = 0; m < max_order; ++m) {
    double up = 0, down = 0;
    for (std::size_t s = 0; s < f.size(); ++s) {
      const Eigen::Index length = f[s].size() - m - 1;
      if (length <= 0) continue;
      const auto forward = f[s].tail(length), backward = b[s].segment(m, length);
      up += 2 * forward.dot(backward);
      down += forward.squaredNorm() + backward.squaredNorm();
    }
    if (!(down > 0)) break;
    const double k = up / down;
    std::vector<double> next = a;
    for (std::size_t i = 0; i < a.size(); ++i) next[i] = a[i] - k * a[a.size() - 1 - i];
    next.push_back(k);
    a = std::move(next);
    for (std::size_t s = 0; s < f.size(); ++s) {
      const Eigen::Index length = f[s].size() - m - 1;
      if (length <= 0) continue;
      const Eigen::VectorXd forward = f[s].tail(length), backward = b[s].segment(m, length);
      f[s].tail(length) = forward - k * backward;
      b[s].segment(m + 1, length) = backward - k * forward;
    }
    power *= 1 - k * k;
    const double p = m + 1;
    const double score = n * std::log(power) + 2 * p * n / std::max(1.0, n - p - 1);
    if (score < best_score) {
      best_score = score;
      best = a;
      sigma = std::sqrt(power);
    }
  }
  return best;
}

/// Innovations. The first samples have no full past and are left out: as many for every order, so that
/// likelihoods of different noise models compare.
void filter(const std::vector<double>& a, int max_order, Eigen::Ref<Eigen::VectorXd> x) {
  for (Eigen::Index i = x.size() - 1; i >= 0; --i) {
    const auto order = std::min<Eigen::Index>(i, static_cast<Eigen::Index>(a.size()));
    double predicted = 0;
    for (Eigen::Index k = 0; k < order; ++k) predicted += a[static_cast<std::size_t>(k)] * x[i - 1 - k];
    x[i] -= predicted;
  }
  x.head(std::min<Eigen::Index>(x.size() / 2, max_order)).setZero();
}

}  // namespace

NoiseModel::NoiseModel(const RegressionProblem& problem, const Eigen::VectorXd& rest, int parameters,
                       int max_order, double temperature)
    : problem_(problem), max_order_(kSettle), filters_(static_cast<std::size_t>(problem.flights())) {
  const int n = problem.samples();
  const double rate = 1 / problem.period();
  // what the fitted parameters took from the noise, a channel
  const double inflation = 1.0 / std::max(0.5, 1.0 - parameters / (6.0 * std::max(1, n)));
  for (int flight = 0; flight < problem.flights(); ++flight)
    for (int c = 0; c < 6; ++c) {
      std::vector<Eigen::VectorXd> parts;
      for (const Stretch& s : problem.stretches())
        if (s.flight == flight) parts.push_back(rest.segment(c * n + s.begin, s.size()));
      Filter& f = filters_[static_cast<std::size_t>(flight)][static_cast<std::size_t>(c)];
      f.a = burg(parts, max_order, f.sigma);
      if (!(f.sigma > 1e-9 * problem.scale(c))) f.sigma = 0;
      f.sigma *= std::sqrt(inflation);
      f.band.assign(kEdges.size(), 1.0);
    }
  for (const Stretch& s : problem.stretches())
    for (int c = 0; c < 6; ++c) {
      const Filter& f = filters_[static_cast<std::size_t>(s.flight)][static_cast<std::size_t>(c)];
      if (f.sigma <= 0) continue;
      Block b;
      b.channel = c;
      b.begin = s.begin;
      b.size = transform_length(s.size());
      b.kept = b.size;
      b.filter = &f;
      Eigen::VectorXd x = rest.segment(c * n + s.begin, b.size);
      filter(f.a, max_order_, x);
      b.weight = ((kDegrees + 1) / (kDegrees + (x.array() / f.sigma).square())).sqrt();
      b.row = rows_;
      rows_ += b.kept;
      blocks_.push_back(std::move(b));
    }
  // bands whose amplitudes are larger than white ones: slow noise that the autoregression does not describe
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::VectorXd white = apply(rest);
    for (std::size_t flight = 0; flight < filters_.size(); ++flight)
      for (std::size_t c = 0; c < 6; ++c) {
        Filter& f = filters_[flight][c];
        std::vector<double> power(kEdges.size(), kPseudoCount), count(kEdges.size(), kPseudoCount);
        for (const Block& b : blocks_) {
          if (b.filter != &f) continue;
          for (int k = 0; k < b.kept; ++k) {
            const std::size_t band = band_of(0.5 * rate * k / b.size);
            power[band] += white[b.row + k] * white[b.row + k];
            count[band] += 1;
          }
        }
        for (std::size_t band = 0; band < f.band.size(); ++band)
          f.band[band] *= std::sqrt(std::max(1.0, power[band] / count[band]));
      }
  }
  const double root = std::sqrt(std::max(1e-3, temperature));
  for (auto& flight : filters_)
    for (Filter& f : flight)
      for (double& b : f.band) b *= root;
  for (const Block& b : blocks_) log_scale_ -= b.weight.array().log().sum() * b.kept / b.size;
  for (const Block& b : blocks_)
    for (int k = 0; k < b.kept; ++k)
      log_scale_ += std::log(b.filter->sigma * b.filter->band[band_of(0.5 * rate * k / b.size)]);
}

Eigen::MatrixXd NoiseModel::apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  const int n = problem_.samples();
  const double rate = 1 / problem_.period();
  Eigen::MatrixXd out(rows_, columns.cols());
  Eigen::VectorXd x;
  int length = 0;
  std::optional<CosineTransform> transform;
  for (const Block& b : blocks_) {
    if (!transform || length != b.size) transform.emplace(length = b.size);
    Eigen::VectorXd scale(b.kept);
    for (int k = 0; k < b.kept; ++k)
      scale[k] = 1 / (b.filter->sigma * b.filter->band[band_of(0.5 * rate * k / b.size)]);
    for (Eigen::Index col = 0; col < columns.cols(); ++col) {
      x = columns.col(col).segment(b.channel * n + b.begin, b.size);
      if (x.isZero(0)) {
        out.col(col).segment(b.row, b.kept).setZero();
        continue;
      }
      filter(b.filter->a, max_order_, x);
      x.array() *= b.weight.array();
      transform->apply(x);
      out.col(col).segment(b.row, b.kept) = x.head(b.kept).cwiseProduct(scale);
    }
  }
  return out;
}

double NoiseModel::innovation(int channel) const {
  double sum = 0;
  for (const auto& f : filters_) sum += f[static_cast<std::size_t>(channel)].sigma;
  return filters_.empty() ? 0.0 : sum / static_cast<double>(filters_.size());
}

}  // namespace omniflight::diagnosis
