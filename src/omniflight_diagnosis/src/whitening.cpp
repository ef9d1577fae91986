#include "whitening.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

/// Coefficients of an autoregression one order higher, by the reflection coefficient k.
std::vector<double> reflected(const std::vector<double>& a, double k) {
  std::vector<double> next(a.size() + 1);
  for (std::size_t i = 0; i < a.size(); ++i) next[i] = a[i] - k * a[a.size() - 1 - i];
  next.back() = k;
  return next;
}

/// Burg's recursion with the sums taken over all runs of one flight and channel.
std::vector<double> burg(const std::vector<Eigen::VectorXd>& runs, int order) {
  std::vector<Eigen::VectorXd> forward = runs, backward = runs;
  std::vector<double> a;
  for (int m = 1; m <= order; ++m) {
    double above = 0, below = 0;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const Eigen::Index n = runs[r].size() - m;
      if (n <= 0) continue;
      const auto f = forward[r].segment(m, n);
      const auto b = backward[r].segment(m - 1, n);
      above += 2 * f.dot(b);
      below += f.squaredNorm() + b.squaredNorm();
    }
    if (!(below > 0)) break;
    const double k = above / below;
    a = reflected(a, k);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const Eigen::Index n = runs[r].size() - m;
      if (n <= 0) continue;
      const Eigen::VectorXd f = forward[r].segment(m, n), b = backward[r].segment(m - 1, n);
      forward[r].segment(m, n) = f - k * b;
      backward[r].segment(m, n) = b - k * f;
    }
  }
  return a;
}

/// Autocovariances of lags 0 to `lags` of the process x_i = sum a_k x_(i-1-k) + sigma e_i.
std::vector<double> autocovariance(const std::vector<double>& a, double sigma, int lags) {
  std::vector<double> h{1.0};  // impulse response, until it has died
  constexpr int kLongest = 8000;
  double energy = 1;
  for (int i = 1; i < kLongest; ++i) {
    double v = 0;
    for (std::size_t k = 0; k < a.size() && static_cast<int>(k) < i; ++k)
      v += a[k] * h[static_cast<std::size_t>(i) - 1 - k];
    h.push_back(v);
    energy += v * v;
    if (i > 8 * lags && v * v < 1e-12 * energy) break;
  }
  std::vector<double> r(static_cast<std::size_t>(lags) + 1, 0.0);
  for (std::size_t k = 0; k < r.size(); ++k) {
    for (std::size_t i = k; i < h.size(); ++i) r[k] += h[i] * h[i - k];
    r[k] *= sigma * sigma;
  }
  return r;
}

/// Levinson's recursion: coefficients and innovation variance of the autocovariances; false if they are none.
bool levinson(const std::vector<double>& r, std::vector<double>& a, double& variance) {
  a.clear();
  variance = r[0];
  if (!(variance > 0)) return false;
  for (std::size_t m = 1; m < r.size(); ++m) {
    double k = r[m];
    for (std::size_t i = 0; i < a.size(); ++i) k -= a[i] * r[m - 1 - i];
    k /= variance;
    if (!(std::abs(k) < 1)) return false;
    a = reflected(a, k);
    variance *= 1 - k * k;
  }
  return variance > 0;
}

/// Order of the model of a flight's noise, at most `most`. A long model of a short flight takes what is
/// missing for noise: on real flights of half a minute 24 coefficients took the rotors' inertia with it.
int order_for(Eigen::Index samples, int most) {
  constexpr int kAnyFlight = 8, kSamplesEach = 400, kFewest = 25;
  const int n = static_cast<int>(samples);
  return std::min({most, std::max(kAnyFlight, n / kSamplesEach), n / kFewest});
}

/// Covariance of the process times every column: the filter 1/A backwards, then forwards.
Eigen::MatrixXd covariance_times(const std::vector<double>& a, double sigma, const Eigen::MatrixXd& Q) {
  Eigen::MatrixXd G = Q;
  const auto p = static_cast<Eigen::Index>(a.size());
  for (Eigen::Index c = 0; c < G.cols(); ++c) {
    for (Eigen::Index i = G.rows() - 1; i >= 0; --i)
      for (Eigen::Index k = 0; k < p && i + 1 + k < G.rows(); ++k)
        G(i, c) += a[static_cast<std::size_t>(k)] * G(i + 1 + k, c);
    for (Eigen::Index i = 0; i < G.rows(); ++i)
      for (Eigen::Index k = 0; k < p && k < i; ++k)
        G(i, c) += a[static_cast<std::size_t>(k)] * G(i - 1 - k, c);
  }
  return sigma * sigma * G;
}

}  // namespace

Whitening Whitening::scale_only(const Problem& problem, const Eigen::VectorXd& residual) {
  Whitening w;
  w.filters_.resize(static_cast<std::size_t>(problem.flights()));
  w.finish(problem, residual);
  return w;
}

Whitening Whitening::autoregressive(const Problem& problem, const Eigen::VectorXd& residual, int order) {
  Whitening w;
  w.filters_.resize(static_cast<std::size_t>(problem.flights()));
  for (int f = 0; f < problem.flights(); ++f) {
    for (int c = 0; c < 6; ++c) {
      std::vector<Eigen::VectorXd> parts;
      Eigen::Index count = 0;
      for (const Run& run : problem.runs()) {
        if (run.flight != f) continue;
        parts.push_back(residual.segment(c * problem.samples() + run.begin, run.end - run.begin));
        count += parts.back().size();
      }
      const int p = order_for(count, order);
      w.skip_ = std::max(w.skip_, p);
      w.filters_[static_cast<std::size_t>(f)][static_cast<std::size_t>(c)].a = burg(parts, p);
    }
  }
  w.finish(problem, residual);
  return w;
}

Whitening Whitening::autoregressive(const Problem& problem, const Eigen::VectorXd& residual, int order,
                                    const std::array<Eigen::MatrixXd, 6>& columns) {
  Whitening w = autoregressive(problem, residual, order);
  for (int c = 0; c < 6; ++c) w.give_back(problem, c, columns[static_cast<std::size_t>(c)]);
  return w;
}

void Whitening::give_back(const Problem& problem, int channel, const Eigen::MatrixXd& columns) {
  const auto filter = [&](int flight) -> Filter& {
    return filters_[static_cast<std::size_t>(flight)][static_cast<std::size_t>(channel)];
  };
  std::vector<std::vector<double>> left;
  for (int f = 0; f < problem.flights(); ++f)
    left.push_back(autocovariance(filter(f).a, filter(f).sigma, static_cast<int>(filter(f).a.size())));
  const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ() *
                            Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    // covariance C of the noise, projector M = 1 - QQ': what remains has covariance MCM = C - QD' - DQ'
    Eigen::MatrixXd D(Q.rows(), Q.cols());
    for (const Run& run : problem.runs())
      D.middleRows(run.begin, run.end - run.begin) = covariance_times(
          filter(run.flight).a, filter(run.flight).sigma, Q.middleRows(run.begin, run.end - run.begin));
    D -= 0.5 * Q * (Q.transpose() * D);
    for (int f = 0; f < problem.flights(); ++f) {
      std::vector<double> r = left[static_cast<std::size_t>(f)];
      for (std::size_t k = 0; k < r.size(); ++k) {
        double taken = 0;
        int pairs = 0;
        const int lag = static_cast<int>(k);
        for (const Run& run : problem.runs()) {
          const int n = run.end - run.begin - lag;
          if (run.flight != f || n <= 0) continue;
          taken += Q.middleRows(run.begin, n).cwiseProduct(D.middleRows(run.begin + lag, n)).sum() +
                   Q.middleRows(run.begin + lag, n).cwiseProduct(D.middleRows(run.begin, n)).sum();
          pairs += n;
        }
        if (pairs > 0) r[k] += taken / pairs;
      }
      std::vector<double> a;
      double variance = 0;
      if (!levinson(r, a, variance)) continue;  // more than there was: keep what was found so far
      filter(f).a = std::move(a);
      filter(f).sigma = std::sqrt(variance);
    }
  }
}

void Whitening::finish(const Problem& problem, const Eigen::VectorXd& residual) {
  const Eigen::VectorXd e = apply_vector(problem, residual);
  const int n = problem.samples();
  std::vector<std::array<double, 6>> sum(filters_.size());
  std::vector<int> count(filters_.size(), 0);
  for (const Run& run : problem.runs()) {
    const auto f = static_cast<std::size_t>(run.flight);
    count[f] += std::max(0, run.end - run.begin - skip_);
    for (int c = 0; c < 6; ++c)
      sum[f][static_cast<std::size_t>(c)] += e.segment(c * n + run.begin, run.end - run.begin).squaredNorm();
  }
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    for (std::size_t c = 0; c < 6; ++c) {
      const double variance = count[f] > 0 ? sum[f][c] / count[f] : 1.0;
      // a floor far below any sensor keeps exact simulations finite
      filters_[f][c].sigma = std::sqrt(std::max(variance, c < 3 ? 1e-18 : 1e-22));
      per_channel_[c] -= count[f] * std::log(filters_[f][c].sigma);
    }
    samples_ += 6 * count[f];
  }
  for (double l : per_channel_) log_likelihood_ += l;
}

Eigen::VectorXd Whitening::apply_vector(const Problem& problem, const Eigen::VectorXd& x) const {
  return apply(problem, x);
}

Eigen::MatrixXd Whitening::apply(const Problem& problem, const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(x.rows(), x.cols());
  const int n = problem.samples();
  for (Eigen::Index column = 0; column < x.cols(); ++column)
    for (int c = 0; c < (problem.forces_only() ? 3 : 6); ++c)
      apply_channel(problem, c, x.col(column).segment(static_cast<Eigen::Index>(c) * n, n),
                    out.col(column).segment(static_cast<Eigen::Index>(c) * n, n));
  return out;
}

void Whitening::apply_channel(const Problem& problem, int channel, const Eigen::Ref<const Eigen::VectorXd>& x,
                              Eigen::Ref<Eigen::VectorXd> out) const {
  constexpr int kBlock = 512;  // samples side by side, so that no sum waits for its last term
  for (const Run& run : problem.runs()) {
    const Filter& filter = filters_[static_cast<std::size_t>(run.flight)][static_cast<std::size_t>(channel)];
    out.segment(run.begin, std::min(skip_, run.end - run.begin)).setZero();
    for (int begin = run.begin + skip_; begin < run.end; begin += kBlock) {
      const int length = std::min(kBlock, run.end - begin);
      Eigen::Index from = begin;
      auto to = out.segment(from, length);
      to = x.segment(from, length);
      for (const double a : filter.a) to -= a * x.segment(--from, length);
      to *= 1.0 / filter.sigma;
    }
  }
}

}  // namespace omniflight::diagnosis
