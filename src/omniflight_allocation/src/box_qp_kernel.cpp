// Principal pivoting of one box program, compiled once for every instruction set and chosen at run time. A
// row of the matrix is one vector, or a few. No fused multiply-add, no contraction and no sum across a
// vector: every processor gives the same bits.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "box_qp_workspace.hpp"

// processors without SSE4 take the plain path: every target costs seconds of compilation
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "box_qp_kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "rows-inl.hpp"
#include "sweeps-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace omniflight::allocation::qp_kernel {
namespace HWY_NAMESPACE {
constexpr double kPrimalTolerance = 1e-12;  // of the largest bound
constexpr double kDualTolerance = 1e-14;    // of 1 + max |g|, with max diag H = 1; rounding is 1e-15
constexpr double kRefined = 1e-14;          // residual that needs no refinement
constexpr double kStale = 1e-11;            // residual after which pivots are taken anew
constexpr int kBlockTrials = 5;             // block exchanges without progress before single pivots
constexpr int kMaxIterations = 1000;
constexpr int kMaxExchanges = 64;  // pivots until the sweeps begin anew: each adds its rounding
constexpr int kRefinements = 3, kRounds = 4;

/// P columns, padded: variables beyond n have no gradient and the bounds 0.
template <int P>
struct Kernel : Sweeps<P> {
  using R = Rows<P>;
  using R::d, R::kLanes, R::kParts, R::load, R::store, R::each, R::mask, R::bits, R::largest, R::clip;
  using typename R::Row;
  using typename R::V;
  using Sweeps<P>::exchange, Sweeps<P>::sweep_from;

  // One program in scaled variables v = u / scale.
  QpWorkspace& w;
  double scale = 1, dual_tolerance = 0, residual = 0;
  std::uint32_t valid = 0, at_low = 0, at_high = 0;
  // c: of a free variable its distance from `shift`, of a held one minus its gradient
  alignas(64) double g[P], lo[P], hi[P], shift[P], c[P], v[P], gradient[P];

  explicit Kernel(QpWorkspace& workspace) : w(workspace) {}

  std::uint32_t free() const { return valid & ~(at_low | at_high); }

  /// c for the active set with nothing swept: minus the gradient at the shift.
  HWY_INLINE Row minus_gradient_at_shift() const {
    Row sum = each([&](int k) HWY_ATTR { return hn::Neg(hn::Load(d, g + k * kLanes)); });
    for (std::uint32_t rest = at_low | at_high; rest != 0; rest &= rest - 1) {
      const int j = std::countr_zero(rest);
      const V s = hn::Set(d, shift[j]);
      for (int k = 0; k < kParts; ++k)
        sum.part[k] = hn::Sub(sum.part[k], hn::Mul(hn::Load(d, w.h + j * P + k * kLanes), s));
    }
    return sum;
  }

  /// Sweeps the free variables of the matrix anew.
  HWY_INLINE bool rebuild() {
    for (std::uint32_t rest = free(); rest != 0; rest &= rest - 1) shift[std::countr_zero(rest)] = 0.0;
    w.swept = true;
    w.stiff = false;
    w.exchanges = 0;
    w.pivoted = 0;
    Row right = minus_gradient_at_shift();
    if constexpr (P == 8) {
      Row t[P];
      for (int i = 0; i < P; ++i) t[i] = load(w.h + i * P);
      double smallest = 1.0;
      if (!Sweeps<P>::template sweep_from<0>(t, right, free(), smallest)) return w.swept = false;
      w.stiff = smallest < kStiff;
      for (int i = 0; i < P; ++i) store(t[i], w.t + i * P);
      store(right, c);
      w.pivoted = free();
      return true;
    } else {
      for (int i = 0; i < w.n; ++i) store(load(w.h + i * P), w.t + i * P);
      store(right, c);
      for (std::uint32_t rest = free(); rest != 0; rest &= rest - 1)
        if (!exchange(w, c, std::countr_zero(rest), true)) return w.swept = false;
      w.exchanges = 0;
      return true;
    }
  }

  /// c from pivots that a program before has left: q is the gradient at the shift; of a free variable comes
  /// minus inverse times q, of a held one minus its gradient.
  HWY_INLINE void right_side_of_kept_pivots() {
    alignas(64) double q[P];
    Row right = minus_gradient_at_shift();
    store(right, q);
    for (int k = 0; k < kParts; ++k) right.part[k] = hn::IfThenZeroElse(mask(w.pivoted, k), right.part[k]);
    for (std::uint32_t rest = w.pivoted; rest != 0; rest &= rest - 1) {
      const int j = std::countr_zero(rest);
      const V s = hn::Set(d, q[j]);
      for (int k = 0; k < kParts; ++k)
        right.part[k] = hn::Sub(right.part[k], hn::Mul(hn::Load(d, w.t + j * P + k * kLanes), s));
    }
    store(right, c);
  }

  /// Brings the pivots to the active set; held variables stand at their bounds already (`shift`).
  HWY_INLINE bool follow_active_set() {
    const std::uint32_t changed = w.pivoted ^ free();
    const int count = std::popcount(changed);
    if (!w.swept || w.exchanges + count > kMaxExchanges || 2 * count > std::popcount(free()) + 2)
      return rebuild();
    const std::uint32_t entering = changed & free();
    for (std::uint32_t out = changed & w.pivoted; out != 0; out &= out - 1)
      if (!exchange(w, c, std::countr_zero(out), false)) return rebuild();
    for (std::uint32_t in = entering; in != 0; in &= in - 1)
      if (!exchange(w, c, std::countr_zero(in), true)) return rebuild();
    return true;
  }

  /// gradient and residual at v.
  HWY_INLINE void check() {
    Row even = load(g), odd{};
    for (int k = 0; k < kParts; ++k) odd.part[k] = hn::Zero(d);
    for (int j = 0; j < P; j += 2) {
      const V a = hn::Set(d, v[j]), b = hn::Set(d, v[j + 1]);
      for (int k = 0; k < kParts; ++k) {
        even.part[k] = hn::Add(even.part[k], hn::Mul(hn::Load(d, w.h + j * P + k * kLanes), a));
        odd.part[k] = hn::Add(odd.part[k], hn::Mul(hn::Load(d, w.h + (j + 1) * P + k * kLanes), b));
      }
    }
    Row worst;
    for (int k = 0; k < kParts; ++k) {
      const V y = hn::Add(even.part[k], odd.part[k]), x = hn::Load(d, v + k * kLanes);
      hn::Store(y, d, gradient + k * kLanes);
      const V moved = clip(hn::Sub(x, y), hn::Load(d, lo + k * kLanes), hn::Load(d, hi + k * kLanes));
      worst.part[k] = hn::Abs(hn::Sub(x, moved));
    }
    residual = largest(worst);
  }

  /// The gradient at v without its rounding, which a stiff matrix would divide by its smallest pivots.
  void exact_gradient() {
    for (int i = 0; i < w.n; ++i) {
      long double sum = g[i];
      for (int j = 0; j < w.n; ++j) sum += static_cast<long double>(w.h[i * P + j]) * v[j];
      gradient[i] = static_cast<double>(sum);
    }
  }

  struct Wrong {
    std::uint32_t below, above, release;
    std::uint32_t any() const { return below | above | release; }
  };

  /// Variables whose state does not fit c, and v from it.
  HWY_INLINE Wrong wrong() {
    const V primal = hn::Set(d, kPrimalTolerance), dual = hn::Set(d, dual_tolerance), minus = hn::Neg(dual);
    const std::uint32_t open = free();
    Row x;
    for (int k = 0; k < kParts; ++k) {
      const V held = hn::Load(d, shift + k * kLanes);
      x.part[k] = hn::IfThenElse(mask(open, k), hn::Add(held, hn::Load(d, c + k * kLanes)), held);
    }
    const std::uint32_t below = bits(
        [&](int k) HWY_ATTR { return hn::Lt(x.part[k], hn::Sub(hn::Load(d, lo + k * kLanes), primal)); });
    const std::uint32_t above = bits(
        [&](int k) HWY_ATTR { return hn::Gt(x.part[k], hn::Add(hn::Load(d, hi + k * kLanes), primal)); });
    store(x, v);
    std::uint32_t release = 0;
    if (open != valid) {
      release = at_low & bits([&](int k) HWY_ATTR { return hn::Gt(hn::Load(d, c + k * kLanes), dual); });
      release |= at_high & bits([&](int k) HWY_ATTR { return hn::Lt(hn::Load(d, c + k * kLanes), minus); });
    }
    return {below & open, above & open, release};
  }

  HWY_INLINE void change(const Wrong& which, std::uint32_t among) {
    for (std::uint32_t rest = (which.below | which.above) & among; rest != 0; rest &= rest - 1) {
      const int j = std::countr_zero(rest);
      const bool low = (which.below >> j & 1u) != 0;
      const double bound = low ? lo[j] : hi[j];
      c[j] += shift[j] - bound;
      shift[j] = bound;
    }
    at_low = (at_low & ~(which.release & among)) | (which.below & among);
    at_high = (at_high & ~(which.release & among)) | (which.above & among);
  }

  /// Refines v with the true gradient; then c is what a further pivot would begin from.
  HWY_INLINE void polish() {
    for (int k = 0; k < kParts; ++k) {
      const int at = k * kLanes;
      hn::Store(clip(hn::Load(d, v + at), hn::Load(d, lo + at), hn::Load(d, hi + at)), d, v + at);
    }
    check();
  }
  HWY_INLINE void refine() {
    for (int trial = 0; trial < kRefinements && (residual > kRefined || (w.stiff && trial == 0)); ++trial) {
      const double before = std::max(residual, kRefined);
      if (w.stiff) exact_gradient();
      const Row old = load(v), old_gradient = load(gradient);
      Row sum = old;
      for (std::uint32_t rest = w.pivoted; rest != 0; rest &= rest - 1) {
        const int j = std::countr_zero(rest);
        const V s = hn::Set(d, gradient[j]);
        for (int k = 0; k < kParts; ++k)
          sum.part[k] = hn::Add(sum.part[k], hn::Mul(hn::Load(d, w.t + j * P + k * kLanes), s));
      }
      for (int k = 0; k < kParts; ++k)
        sum.part[k] = hn::IfThenElse(mask(w.pivoted, k), sum.part[k], old.part[k]);
      store(sum, v);
      for (int k = 0; k < kParts; ++k)  // before it is clipped: what a further pivot begins from
        hn::Store(hn::Sub(sum.part[k], hn::Load(d, shift + k * kLanes)), d, c + k * kLanes);
      polish();
      if (!(residual > before)) continue;
      store(old, v);
      store(old_gradient, gradient);
      for (int k = 0; k < kParts; ++k)
        hn::Store(hn::Sub(old.part[k], hn::Load(d, shift + k * kLanes)), d, c + k * kLanes);
      residual = before;
      break;
    }
    for (int k = 0; k < kParts; ++k)
      hn::Store(hn::IfThenElse(mask(w.pivoted, k), hn::Load(d, c + k * kLanes),
                               hn::Neg(hn::Load(d, gradient + k * kLanes))),
                d, c + k * kLanes);
  }

  QpStatus pivot(int& iterations) {
    int fewest = std::numeric_limits<int>::max(), trials = kBlockTrials, rounds = 0;
    bool anew = false;
    for (iterations = 1; iterations <= kMaxIterations; ++iterations) {
      if (anew ? !rebuild() : !follow_active_set()) return QpStatus::not_convex;
      anew = false;
      Wrong which = wrong();
      if (which.any() == 0) {
        polish();
        if (residual <= kRefined && !w.stiff) return QpStatus::solved;
        refine();
        const double refined = residual;
        which = wrong();
        if (which.any() == 0 || rounds++ == kRounds) {
          polish();
          if (!(refined > kStale) || w.exchanges == 0) return QpStatus::solved;
          anew = true;  // the pivots have gathered too much rounding
          continue;
        }
      }
      const int count = std::popcount(which.any());
      if (count < fewest)
        fewest = count, trials = kBlockTrials;
      else
        --trials;
      const bool block = trials >= 0;
      change(which, block ? valid : 1u << (std::bit_width(which.any()) - 1));
    }
    polish();
    return QpStatus::iteration_limit;
  }

  /// n numbers and zeros, as rows are.
  static HWY_INLINE Row padded(const double* p, int n) {
    if (n == P) return each([&](int k) HWY_ATTR { return hn::LoadU(d, p + k * kLanes); });
    alignas(64) double copy[P] = {};
    std::copy_n(p, n, copy);
    return load(copy);
  }

  /// Checks and scales bounds and linear term; the first guess of the active set.
  HWY_INLINE QpStatus begin(const Terms& in) {
    const int n = w.n;
    const V infinity = hn::Set(d, HUGE_VAL), zero = hn::Zero(d);
    const Row low = padded(in.lower, n), high = padded(in.upper, n), linear = padded(in.g, n);
    Row sizes, slopes;
    bool finite = true, known = true, ordered = true;
    for (int k = 0; k < kParts; ++k) {
      const V l = low.part[k], h = high.part[k], al = hn::Abs(l), ah = hn::Abs(h);
      slopes.part[k] = hn::Abs(linear.part[k]);
      finite = finite & hn::AllTrue(d, hn::Lt(slopes.part[k], infinity));
      known = known & hn::AllTrue(d, hn::And(hn::Eq(l, l), hn::Eq(h, h)));
      ordered = ordered & hn::AllTrue(d, hn::And(hn::Le(l, h),
                                                 hn::And(hn::Lt(l, infinity), hn::Gt(h, hn::Neg(infinity)))));
      sizes.part[k] =
          hn::Max(hn::IfThenElseZero(hn::Lt(al, infinity), al), hn::IfThenElseZero(hn::Lt(ah, infinity), ah));
    }
    if (!finite || !known) return QpStatus::not_finite;
    if (!ordered) return QpStatus::bad_bounds;
    const double most = largest(sizes);
    scale = most == 0.0 ? 1.0 : most;
    const double inverse_g = 1.0 / (w.h_scale * scale), inverse_u = 1.0 / scale;
    dual_tolerance = kDualTolerance * (1.0 + largest(slopes) * inverse_g);
    for (int k = 0; k < kParts; ++k) {
      const int at = k * kLanes;
      const V vu = hn::Set(d, inverse_u);
      hn::Store(hn::Mul(linear.part[k], hn::Set(d, inverse_g)), d, g + at);
      hn::Store(hn::Mul(low.part[k], vu), d, lo + at);
      hn::Store(hn::Mul(high.part[k], vu), d, hi + at);
      hn::Store(zero, d, shift + at);
    }
    valid = (1u << n) - 1u;
    for (int j = 0; j < n; ++j) {
      if (in.start[j] == 0) continue;
      const double bound = in.start[j] < 0 ? lo[j] : hi[j];
      if (std::abs(bound) == HUGE_VAL) continue;
      shift[j] = bound;
      (in.start[j] < 0 ? at_low : at_high) |= 1u << j;
    }
    return QpStatus::solved;
  }

  void run(const Terms& in, BoxQpSolution& out) {
    out.status = begin(in);
    if (out.status != QpStatus::solved) return;
    if (w.swept) right_side_of_kept_pivots();
    out.status = pivot(out.iterations);
    if (out.status == QpStatus::not_convex) return;
    const int n = w.n;
    out.kkt_residual = residual;
    out.active_bounds = std::popcount(at_low | at_high);
    out.u.resize(n);
    alignas(64) double u[P];
    const Row lower = padded(in.lower, n), upper = padded(in.upper, n);
    for (int k = 0; k < kParts; ++k) {
      const V inside =
          clip(hn::Mul(hn::Load(d, v + k * kLanes), hn::Set(d, scale)), lower.part[k], upper.part[k]);
      const V held = hn::IfThenElse(mask(at_high, k), upper.part[k], inside);
      hn::Store(hn::IfThenElse(mask(at_low, k), lower.part[k], held), d, u + k * kLanes);
    }
    std::copy_n(u, n, out.u.data());
    for (std::uint32_t rest = at_low; rest != 0; rest &= rest - 1)
      out.active_set[static_cast<std::size_t>(std::countr_zero(rest))] = -1;
    for (std::uint32_t rest = at_high; rest != 0; rest &= rest - 1)
      out.active_set[static_cast<std::size_t>(std::countr_zero(rest))] = 1;
  }
};

QpStatus SetMatrix(const double* H, int n, QpWorkspace& w) {
  return n <= 8 ? Sweeps<8>::set_matrix(H, n, w) : Sweeps<16>::set_matrix(H, n, w);
}

void Solve(const Terms& in, QpWorkspace& w, BoxQpSolution& out) {
  if (w.n <= 8) {
    Kernel<8> kernel(w);
    kernel.run(in, out);
  } else {
    Kernel<16> kernel(w);
    kernel.run(in, out);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::allocation::qp_kernel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace omniflight::allocation::qp_kernel {

HWY_EXPORT(SetMatrix);
HWY_EXPORT(Solve);

QpStatus set_matrix(const double* H, int n, QpWorkspace& w) {
  return HWY_DYNAMIC_DISPATCH(SetMatrix)(H, n, w);
}
void solve(const Terms& terms, QpWorkspace& w, BoxQpSolution& out) {
  HWY_DYNAMIC_DISPATCH(Solve)(terms, w, out);
}

}  // namespace omniflight::allocation::qp_kernel
#endif
