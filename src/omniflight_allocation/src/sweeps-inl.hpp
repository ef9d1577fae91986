// The sweep operator (Goodnight, 1979) on the symmetric matrix of a workspace and one right-hand side c.
// Swept by the set F, t holds -H_FF^-1, H_BF H_FF^-1 and the Schur complement of H_FF; c holds H_FF^-1 c_F
// and c_B - H_BF H_FF^-1 c_F. Products of a row with itself keep t symmetric to the bit. Included once for
// every instruction set.
#if defined(OMNIFLIGHT_ALLOCATION_SWEEPS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef OMNIFLIGHT_ALLOCATION_SWEEPS_INL
#undef OMNIFLIGHT_ALLOCATION_SWEEPS_INL
#else
#define OMNIFLIGHT_ALLOCATION_SWEEPS_INL
#endif

#include <algorithm>
#include <cmath>

#include "box_qp_workspace.hpp"
#include "rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace omniflight::allocation::qp_kernel {
namespace HWY_NAMESPACE {

template <int P>
struct Sweeps : Rows<P> {
  using R = Rows<P>;
  using R::d, R::kLanes, R::kParts, R::load, R::store, R::each;
  using typename R::M;
  using typename R::Row;
  using typename R::V;

  /// Checks, mirrors and scales a matrix of n x n of which the lower triangle is read.
  static QpStatus set_matrix(const double* H, int n, QpWorkspace& w) {
    double most = 0.0;
    bool positive = true;
    for (int j = 0; j < n; ++j) {
      const double diagonal = H[j * n + j];
      positive = positive & (diagonal > 0.0 || std::isnan(diagonal));
      most = std::max(most, diagonal);
    }
    if (n == P) {
      for (int j = 0; j < P; ++j)
        for (int k = 0; k < kParts; ++k)
          hn::Store(hn::LoadU(d, H + j * P + k * kLanes), d, w.h + j * P + k * kLanes);
#pragma GCC unroll 16
      for (int i = 1; i < P; ++i)
#pragma GCC unroll 16
        for (int j = 0; j < i; ++j) w.h[i * P + j] = H[j * P + i];
    } else {
      std::fill_n(w.h, P * P, 0.0);
      for (int j = 0; j < n; ++j)
        for (int i = j; i < n; ++i) w.h[j * P + i] = w.h[i * P + j] = H[j * n + i];
    }
    V even = hn::Zero(d), odd = even;
    const V inverse = hn::Set(d, 1.0 / most), zero = hn::Zero(d);
    for (int at = 0; at < P * P; at += 2 * kLanes) {
      const V a = hn::Load(d, w.h + at), b = hn::Load(d, w.h + at + kLanes);
      even = hn::Add(even, hn::Mul(a, zero));  // NaN from whatever is not finite
      odd = hn::Add(odd, hn::Mul(b, zero));
      hn::Store(hn::Mul(a, inverse), d, w.h + at);
      hn::Store(hn::Mul(b, inverse), d, w.h + at + kLanes);
    }
    if (!hn::AllTrue(d, hn::Eq(hn::Add(even, odd), zero))) return QpStatus::not_finite;
    if (!positive) return QpStatus::not_convex;
    w.h_scale = most;
    w.n = n;
    w.swept = false;
    w.pivoted = 0;
    w.exchanges = 0;
    return QpStatus::solved;
  }

  /// Sweeps variable j, or takes its sweep back; false when the pivot has the wrong sign.
  static HWY_INLINE bool exchange(QpWorkspace& w, double* c, int j, bool in) {
    double* const r = w.t + j * P;
    const double pivot = r[j];
    if (in ? !(pivot > 0.0) : !(pivot < 0.0)) return false;
    if (in && pivot < kStiff) w.stiff = true;
    const double inverse = 1.0 / pivot, signed_inverse = in ? inverse : -inverse;
    const V vi = hn::Set(d, inverse);
    const double step = c[j] * inverse;
    const V e = hn::Set(d, step);
    M here[kParts];
    Row row, old = load(r), right = load(c);
    for (int k = 0; k < kParts; ++k) {
      here[k] = hn::Eq(hn::Iota(d, k * kLanes), hn::Set(d, j));
      right.part[k] = hn::Sub(right.part[k], hn::Mul(old.part[k], e));
      row.part[k] = hn::IfThenElse(here[k], hn::Set(d, in ? 1.0 : -1.0), old.part[k]);
    }
    store(right, c);
    c[j] = in ? step : -step;
    for (int i = 0; i < w.n; ++i) {
      if (i == j) continue;
      double* const ti = w.t + i * P;
      const V ri = hn::Set(d, r[i]);
      for (int k = 0; k < kParts; ++k) {
        const V change = hn::Mul(hn::Mul(row.part[k], ri), vi);
        const V now = hn::Sub(hn::Load(d, ti + k * kLanes), change);
        hn::Store(hn::IfThenElse(here[k], change, now), d, ti + k * kLanes);
      }
    }
    const V vs = hn::Set(d, signed_inverse);
    for (int k = 0; k < kParts; ++k)
      hn::Store(hn::IfThenElse(here[k], hn::Set(d, -inverse), hn::Mul(old.part[k], vs)), d, r + k * kLanes);
    w.pivoted ^= 1u << j;
    ++w.exchanges;
    return true;
  }

  /// The same for a variable known when compiling, with the matrix in registers.
  template <int J>
  static HWY_INLINE bool sweep(Row (&t)[P], Row& right, double& smallest) {
    constexpr int kPart = J / kLanes;
    alignas(64) double r[P], cj[kLanes];
    const Row old = t[J];
    store(old, r);
    hn::Store(right.part[kPart], d, cj);
    const double pivot = r[J];
    if (!(pivot > 0.0)) return false;
    smallest = std::min(smallest, pivot);
    const double inverse = 1.0 / pivot;
    const M here = hn::Eq(hn::Iota(d, kPart * kLanes), hn::Set(d, J));
    const V vi = hn::Set(d, inverse), e = hn::Set(d, cj[J % kLanes] * inverse);
    right = each([&](int k) HWY_ATTR {
      const V now = hn::Sub(right.part[k], hn::Mul(old.part[k], e));
      return k == kPart ? hn::IfThenElse(here, e, now) : now;
    });
    Row row = old;
    row.part[kPart] = hn::IfThenElse(here, hn::Set(d, 1.0), row.part[kPart]);
    for (int i = 0; i < P; ++i) {
      if (i == J) continue;
      const V ri = hn::Set(d, r[i]);
      for (int k = 0; k < kParts; ++k) {
        const V change = hn::Mul(hn::Mul(row.part[k], ri), vi);
        const V now = hn::Sub(t[i].part[k], change);
        t[i].part[k] = k == kPart ? hn::IfThenElse(here, change, now) : now;
      }
    }
    t[J] = each([&](int k) HWY_ATTR {
      const V now = hn::Mul(old.part[k], vi);
      return k == kPart ? hn::IfThenElse(here, hn::Set(d, -inverse), now) : now;
    });
    return true;
  }

  template <int J>
  static HWY_INLINE bool sweep_from(Row (&t)[P], Row& right, std::uint32_t which, double& smallest) {
    if constexpr (J < P) {
      if ((which >> J & 1u) != 0 && !sweep<J>(t, right, smallest)) return false;
      return sweep_from<J + 1>(t, right, which, smallest);
    }
    return true;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::allocation::qp_kernel
HWY_AFTER_NAMESPACE();
#endif
