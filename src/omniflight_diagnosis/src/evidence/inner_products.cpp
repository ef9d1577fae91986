#include "inner_products.hpp"

#include <blis.h>

#include <algorithm>

#include "../numerics/parallel.hpp"

namespace omniflight::diagnosis {
namespace {

/// Without the kernels for small matrices: those of BLIS up to 1.0 read past the end of their operands, and
/// crash where a page ends there (https://github.com/flame/blis/issues/821).
rntm_t packed() {
  rntm_t out = BLIS_RNTM_INITIALIZER;
  bli_rntm_disable_l3_sup(&out);
  return out;
}

}  // namespace

Eigen::MatrixXf inner_products(Eigen::Ref<const Eigen::MatrixXf> a, Eigen::Ref<const Eigen::MatrixXf> b,
                               int threads) {
  constexpr Eigen::Index kPart = 512;  // columns a thread takes at once
  Eigen::MatrixXf out(a.cols(), b.cols());
  if (out.size() == 0) return out;
  if (a.rows() == 0) return out.setZero();
  const Eigen::Index parts = (b.cols() + kPart - 1) / kPart;
  parallel_for(static_cast<std::size_t>(parts), threads, [&](std::size_t k) {
    const Eigen::Index begin = static_cast<Eigen::Index>(k) * kPart;
    const Eigen::Index size = std::min(kPart, b.cols() - begin);
    float one = 1, zero = 0;
    rntm_t runtime = packed();
    // BLIS reads its operands through pointers that are not const
    bli_sgemm_ex(BLIS_TRANSPOSE, BLIS_NO_TRANSPOSE, a.cols(), size, a.rows(), &one,
                 const_cast<float*>(a.data()), 1, a.outerStride(),
                 const_cast<float*>(b.data()) + begin * b.outerStride(), 1, b.outerStride(), &zero,
                 out.data() + begin * out.outerStride(), 1, out.outerStride(), nullptr, &runtime);
  });
  return out;
}

Eigen::MatrixXd inner_products(Eigen::Ref<const Eigen::MatrixXd> a, Eigen::Ref<const Eigen::MatrixXd> b) {
  Eigen::MatrixXd out(a.cols(), b.cols());
  if (out.size() == 0) return out;
  if (a.rows() == 0) return out.setZero();
  double one = 1, zero = 0;
  rntm_t runtime = packed();
  bli_dgemm_ex(BLIS_TRANSPOSE, BLIS_NO_TRANSPOSE, a.cols(), b.cols(), a.rows(), &one,
               const_cast<double*>(a.data()), 1, a.outerStride(), const_cast<double*>(b.data()), 1,
               b.outerStride(), &zero, out.data(), 1, out.outerStride(), nullptr, &runtime);
  return out;
}

Eigen::MatrixXd inner_products(Eigen::Ref<const Eigen::MatrixXd> a) { return inner_products(a, a); }

}  // namespace omniflight::diagnosis
