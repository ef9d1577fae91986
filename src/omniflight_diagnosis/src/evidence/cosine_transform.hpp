// Orthonormal discrete cosine transform (DCT-II), of any length whose prime factors are 2, 3 and 5.
#pragma once

#include <Eigen/Dense>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace omniflight::diagnosis {

/// The largest length not above n with no prime factor but 2, 3 and 5.
int transform_length(int n);

class CosineTransform {
 public:
  explicit CosineTransform(int n);
  /// Amplitudes of n samples; the first n numbers of x, in place (Makhoul 1980: one complex transform).
  void apply(Eigen::Ref<Eigen::VectorXd> x);
  /// The same of two vectors, by one complex transform as well.
  void apply(Eigen::Ref<Eigen::VectorXd> x, Eigen::Ref<Eigen::VectorXd> y);
  /// Samples of n amplitudes, in place.
  void invert(Eigen::Ref<Eigen::VectorXd> x);

 private:
  /// Where the sample at place i of the complex transform comes from: even ones forward, odd ones backward.
  Eigen::Index sample_at(int i) const { return 2 * i < n_ ? 2 * i : 2 * (n_ - i) - 1; }

  int n_;
  Eigen::FFT<double> fft_;
  std::vector<std::complex<double>> turn_, in_, out_;
};

}  // namespace omniflight::diagnosis
