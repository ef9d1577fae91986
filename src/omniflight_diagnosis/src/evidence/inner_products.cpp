#include "inner_products.hpp"

#include <blis.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include <algorithm>
#include <cstdlib>
#include <string>

#include "../numerics/parallel.hpp"

namespace omniflight::diagnosis {
namespace {

#if defined(__x86_64__)
/// BLIS knows processors of AMD by their family, and takes portable kernels, at a sixth of the speed, for
/// those that are newer than itself (0.9 knows up to family 0x19). Its own variable names the kernels to
/// take; it is set before main, where no other thread reads the environment.
[[maybe_unused]] const bool kernels_told = [] {
  __builtin_cpu_init();
  unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
  if (!__builtin_cpu_is("amd") || __get_cpuid(1, &eax, &ebx, &ecx, &edx) == 0) return false;
  const unsigned family = ((eax >> 8) & 0xf) + ((eax >> 20) & 0xff);
  if (family <= 0x19 || !__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return false;
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  return setenv("BLIS_ARCH_TYPE", std::to_string(wide ? BLIS_ARCH_SKX : BLIS_ARCH_HASWELL).c_str(), 0) == 0;
}();
#endif

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

Eigen::MatrixXd inner_products(Eigen::Ref<const Eigen::MatrixXd> a) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(a.cols(), a.cols());
  if (out.size() == 0 || a.rows() == 0) return out;
  double one = 1, zero = 0;
  rntm_t runtime = packed();
  bli_dsyrk_ex(BLIS_LOWER, BLIS_TRANSPOSE, a.cols(), a.rows(), &one, const_cast<double*>(a.data()), 1,
               a.outerStride(), &zero, out.data(), 1, out.outerStride(), nullptr, &runtime);
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
  return out;
}

}  // namespace omniflight::diagnosis
