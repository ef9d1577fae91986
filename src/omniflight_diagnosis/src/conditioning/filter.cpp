#include "omniflight_diagnosis/filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "omniflight_core/frames.hpp"

namespace omniflight::diagnosis {
namespace {

struct Section {
  double b0, b1, b2, a1, a2;
};

constexpr std::array kQuality{0.54119610, 1.3065630};  // of the sections of a 4th-order Butterworth

/// Second-order Butterworth-type section with quality q by the bilinear transform with prewarping.
Section section(double rate_hz, double cutoff_hz, double q) {
  const double k = std::tan(kPi * cutoff_hz / rate_hz);
  const double norm = 1.0 / (1.0 + k / q + k * k);
  return {k * k * norm, 2 * k * k * norm, k * k * norm, 2 * (k * k - 1) * norm, (1 - k / q + k * k) * norm};
}

void run(const Section& s, Eigen::VectorXd& x) {
  // start in the steady state of the first sample
  double z2 = (s.b2 - s.a2) * x[0], z1 = (s.b1 - s.a1) * x[0] + z2;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double in = x[i], out = s.b0 * in + z1;
    z1 = s.b1 * in - s.a1 * out + z2;
    z2 = s.b2 * in - s.a2 * out;
    x[i] = out;
  }
}

}  // namespace

Eigen::MatrixXd low_pass(const Eigen::MatrixXd& x, double rate_hz, double cutoff_hz) {
  const Eigen::Index n = x.rows();
  if (n < 4 || cutoff_hz <= 0 || cutoff_hz >= 0.49 * rate_hz) return x;
  const std::array<Section, 2> sections{section(rate_hz, cutoff_hz, kQuality[0]),
                                        section(rate_hz, cutoff_hz, kQuality[1])};
  const Eigen::Index pad =
      std::min<Eigen::Index>(n - 1, static_cast<Eigen::Index>(3.0 * rate_hz / cutoff_hz));
  Eigen::MatrixXd out(n, x.cols());
  Eigen::VectorXd work(n + 2 * pad);
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    for (Eigen::Index i = 0; i < pad; ++i) {
      work[i] = 2 * x(0, c) - x(pad - i, c);
      work[n + pad + i] = 2 * x(n - 1, c) - x(n - 2 - i, c);
    }
    work.segment(pad, n) = x.col(c);
    for (int pass = 0; pass < 2; ++pass) {
      for (const Section& s : sections) run(s, work);
      work.reverseInPlace();
    }
    out.col(c) = work.segment(pad, n);
  }
  return out;
}

CausalLowPass::CausalLowPass(double rate_hz, double cutoff_hz, Eigen::Index channels)
    : state_(Eigen::MatrixXd::Zero(channels, 4)) {
  Eigen::Index k = 0;
  for (const double q : kQuality) {
    const Section s = section(rate_hz, cutoff_hz, q);
    coefficients_.col(k++) << s.b0, s.b1, s.b2, s.a1, s.a2;
    delay_ += 1.0 / (q * 2 * kPi * cutoff_hz);
  }
}

void CausalLowPass::step(Eigen::Ref<Eigen::VectorXd> x) {
  for (Eigen::Index c = 0; c < state_.rows(); ++c)
    for (Eigen::Index k = 0; k < 2; ++k) {
      const auto b = coefficients_.col(k);
      double &z1 = state_(c, 2 * k), &z2 = state_(c, 2 * k + 1);
      if (fresh_) {
        z2 = (b[2] - b[4]) * x[c];
        z1 = (b[1] - b[3]) * x[c] + z2;
      }
      const double in = x[c], out = b[0] * in + z1;
      z1 = b[1] * in - b[3] * out + z2;
      z2 = b[2] * in - b[4] * out;
      x[c] = out;
    }
  fresh_ = false;
}

Eigen::MatrixXd block_mean(const Eigen::MatrixXd& x, int length) {
  if (length < 2 || x.rows() < length) return x;
  const Eigen::Index n = x.rows();
  const int half = length / 2;
  const bool even = length % 2 == 0;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n, x.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    for (int k = -half; k <= half; ++k) {
      const Eigen::Index at = std::clamp<Eigen::Index>(i + k, 0, n - 1);
      out.row(i) += (even && std::abs(k) == half ? 0.5 : 1.0) * x.row(at);
    }
  return out / length;
}

Eigen::MatrixXd blur(const Eigen::MatrixXd& x, double variance) {
  // Largest variance of one pass of three weights; above 0.5 the response at the Nyquist frequency is
  // negative.
  constexpr double kMost = 0.4;
  const Eigen::Index n = x.rows();
  if (!(variance > 1e-3) || n < 3) return x;
  const int passes = static_cast<int>(std::ceil(variance / kMost));
  const double side = 0.5 * variance / passes;
  Eigen::MatrixXd out = x;
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    auto y = out.col(c);
    for (int pass = 0; pass < passes; ++pass) {
      double before = y[0];
      for (Eigen::Index i = 0; i < n; ++i) {
        const double now = y[i], after = y[std::min(i + 1, n - 1)];
        y[i] = now + side * (before + after - 2 * now);
        before = now;
      }
    }
  }
  return out;
}

Eigen::MatrixXd differentiate(const Eigen::MatrixXd& x, double rate_hz) {
  const Eigen::Index n = x.rows();
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(n, x.cols());
  if (n < 2) return d;
  for (Eigen::Index i = 1; i + 1 < n; ++i) d.row(i) = 0.5 * rate_hz * (x.row(i + 1) - x.row(i - 1));
  d.row(0) = rate_hz * (x.row(1) - x.row(0));
  d.row(n - 1) = rate_hz * (x.row(n - 1) - x.row(n - 2));
  return d;
}

}  // namespace omniflight::diagnosis
