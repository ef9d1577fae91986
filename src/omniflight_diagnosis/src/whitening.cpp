#include "whitening.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

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
    std::vector<double> next(a.size() + 1);
    for (std::size_t i = 0; i < a.size(); ++i) next[i] = a[i] - k * a[a.size() - 1 - i];
    next.back() = k;
    a = next;
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
  w.skip_ = order;
  for (int f = 0; f < problem.flights(); ++f) {
    for (int c = 0; c < 6; ++c) {
      std::vector<Eigen::VectorXd> parts;
      Eigen::Index count = 0;
      for (const Run& run : problem.runs()) {
        if (run.flight != f) continue;
        parts.push_back(residual.segment(c * problem.samples() + run.begin, run.end - run.begin));
        count += parts.back().size();
      }
      const int p = std::min(order, static_cast<int>(count / 25));
      w.filters_[static_cast<std::size_t>(f)][static_cast<std::size_t>(c)].a = burg(parts, p);
    }
  }
  w.finish(problem, residual);
  return w;
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
  for (Eigen::Index column = 0; column < x.cols(); ++column) {
    for (int c = 0; c < (problem.forces_only() ? 3 : 6); ++c) {
      const double* in = x.data() + column * x.outerStride() + c * n;
      double* to = out.data() + column * out.rows() + c * n;
      for (const Run& run : problem.runs()) {
        const Filter& filter = filters_[static_cast<std::size_t>(run.flight)][static_cast<std::size_t>(c)];
        const int p = static_cast<int>(filter.a.size());
        const double scale = 1.0 / filter.sigma;
        for (int i = run.begin + skip_; i < run.end; ++i) {
          double v = in[i];
          for (int k = 0; k < p; ++k) v -= filter.a[static_cast<std::size_t>(k)] * in[i - 1 - k];
          to[i] = v * scale;
        }
      }
    }
  }
  return out;
}

}  // namespace omniflight::diagnosis
