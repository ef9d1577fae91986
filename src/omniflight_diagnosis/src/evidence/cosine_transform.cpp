#include "cosine_transform.hpp"

#include <cmath>
#include <numbers>

namespace omniflight::diagnosis {

int transform_length(int n) {
  for (; n > 1; --n) {
    int left = n;
    for (const int prime : {2, 3, 5})
      while (left % prime == 0) left /= prime;
    if (left == 1) return n;
  }
  return n;
}

CosineTransform::CosineTransform(int n) : n_(n) {
  const auto size = static_cast<std::size_t>(n);
  turn_.resize(size);
  in_.resize(size);
  out_.resize(size);
  for (int k = 0; k < n; ++k)
    turn_[static_cast<std::size_t>(k)] =
        std::polar(std::sqrt((k == 0 ? 1.0 : 2.0) / n), -std::numbers::pi * k / (2.0 * n));
}

void CosineTransform::apply(Eigen::Ref<Eigen::VectorXd> x) {
  if (n_ == 1) return;  // its own amplitude, and no length for a transform
  for (int i = 0; i < n_; ++i) in_[static_cast<std::size_t>(i)] = x[sample_at(i)];
  fft_.fwd(out_, in_);
  for (int k = 0; k < n_; ++k) {
    const auto at = static_cast<std::size_t>(k);
    x[k] = (out_[at] * turn_[at]).real();
  }
}

void CosineTransform::apply(Eigen::Ref<Eigen::VectorXd> x, Eigen::Ref<Eigen::VectorXd> y) {
  if (n_ == 1) return;
  for (int i = 0; i < n_; ++i) in_[static_cast<std::size_t>(i)] = {x[sample_at(i)], y[sample_at(i)]};
  fft_.fwd(out_, in_);
  // the spectrum of the real part is conjugate symmetric, that of the imaginary part antisymmetric
  for (int k = 0; k < n_; ++k) {
    const auto at = static_cast<std::size_t>(k), mirrored = static_cast<std::size_t>(k == 0 ? 0 : n_ - k);
    const std::complex<double> here = out_[at], there = std::conj(out_[mirrored]);
    x[k] = 0.5 * ((here + there) * turn_[at]).real();
    y[k] = 0.5 * ((here - there) * turn_[at]).imag();
  }
}

// exp(-i pi k / 2n) times the spectrum of the reordered samples is C[k] - i C[n - k], with C the amplitudes
// before they are normalised
void CosineTransform::invert(Eigen::Ref<Eigen::VectorXd> x) {
  if (n_ == 1) return;
  for (int k = 0; k < n_; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const auto plain = [&](int i) {
      return i == n_ ? 0.0 : x[i] / std::abs(turn_[static_cast<std::size_t>(i)]);
    };
    out_[at] = std::complex<double>(plain(k), -plain(n_ - k)) * std::abs(turn_[at]) / turn_[at];
  }
  fft_.inv(in_, out_);
  for (int i = 0; i < n_; ++i) x[sample_at(i)] = in_[static_cast<std::size_t>(i)].real();
}

}  // namespace omniflight::diagnosis
