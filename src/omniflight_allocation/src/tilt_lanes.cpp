// Box programs in lanes, compiled once for every instruction set and chosen at run time. No fused
// multiply-add, no contraction: every processor gives the same bits.
#include "tilt_lanes.hpp"

#include <algorithm>

// processors without SSE4 take the plain path: every target costs seconds of compilation
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tilt_lanes.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace omniflight::allocation {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kMaxSweeps = 8;

/// N variables in the lanes from `at` on.
template <int N>
struct Lanes {
  using D = hn::CappedTag<double, kTilts>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  static constexpr D d{};
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D{}));
  static constexpr int at(int i, int j) { return i * (i + 1) / 2 + j; }
  static constexpr int sym(int i, int j) { return i > j ? at(i, j) : at(j, i); }
  static HWY_INLINE V set(double x) { return hn::Set(d, x); }
  static HWY_INLINE V madd(V sum, V a, V b) { return hn::Add(sum, hn::Mul(a, b)); }
  static HWY_INLINE V msub(V sum, V a, V b) { return hn::Sub(sum, hn::Mul(a, b)); }
  static HWY_INLINE M mask(std::uint8_t bits, int first) {
    const std::uint64_t part = static_cast<std::uint64_t>(bits) >> first;
    return hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&part));
  }
  static HWY_INLINE std::uint8_t bits(M m) {
    std::uint64_t part = 0;
    hn::StoreMaskBits(d, m, reinterpret_cast<std::uint8_t*>(&part));
    return static_cast<std::uint8_t>(part);
  }

  V h[N * (N + 1) / 2], g[N], x[N];
  std::uint8_t low[N], high[N];  // of these lanes

  HWY_INLINE void assemble(const TiltTerms& t, const TiltPrograms& p, int first) {
    const V c = hn::Load(d, p.c.data() + first), s = hn::Load(d, p.s.data() + first);
    const V cc = hn::Mul(c, c), ss = hn::Mul(s, s), cs = hn::Mul(c, s);
    for (int e = 0; e < N * (N + 1) / 2; ++e) {
      const auto& q = t.quadratic[static_cast<std::size_t>(e)];
      h[e] = madd(madd(hn::Mul(set(q[0]), cc), set(q[1]), ss), set(q[2]), cs);
    }
    if (t.constant_part)
      for (int e = 0; e < N * (N + 1) / 2; ++e) {
        const auto& q = t.quadratic[static_cast<std::size_t>(e)];
        h[e] = hn::Add(h[e], madd(madd(set(q[3]), set(q[4]), c), set(q[5]), s));
      }
    for (int i = 0; i < N; ++i) {
      const auto k = static_cast<std::size_t>(i);
      h[at(i, i)] = hn::Add(h[at(i, i)], set(p.diagonal[k]));
      g[i] = hn::Neg(madd(madd(set(p.linear[k][2]), set(p.linear[k][0]), c), set(p.linear[k][1]), s));
      low[i] = static_cast<std::uint8_t>(p.at_low[k] >> first);
      high[i] = static_cast<std::uint8_t>(p.at_high[k] >> first);
    }
  }

  /// x for the active sets; lanes whose pivots are all positive.
  template <bool kHeld>
  HWY_INLINE M solve(const TiltTerms& t) {
    V a[N * (N + 1) / 2], held[N];
    M open[N];
    if constexpr (kHeld) {
      const V one = set(1.0), zero = hn::Zero(d);
      for (int i = 0; i < N; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const M is_low = mask(low[i], 0), is_high = mask(high[i], 0);
        open[i] = hn::Not(hn::Or(is_low, is_high));
        held[i] = hn::IfThenElse(is_low, set(t.lower[k]), hn::IfThenElseZero(is_high, set(t.upper[k])));
      }
      for (int i = 0; i < N; ++i) {
        V sum = hn::Neg(g[i]);
        for (int j = 0; j < N; ++j)
          if ((low[j] | high[j]) != 0) sum = msub(sum, h[sym(i, j)], held[j]);
        x[i] = hn::IfThenElse(open[i], sum, held[i]);
        for (int j = 0; j < i; ++j)
          a[at(i, j)] = hn::IfThenElse(hn::And(open[i], open[j]), h[at(i, j)], zero);
        a[at(i, i)] = hn::IfThenElse(open[i], h[at(i, i)], one);
      }
    } else {
      std::copy(h, h + N * (N + 1) / 2, a);
      for (int i = 0; i < N; ++i) x[i] = hn::Neg(g[i]);
    }
    M positive = hn::Gt(a[0], hn::Zero(d));
#pragma GCC unroll 8
    for (int j = 0; j < N; ++j) {
      positive = hn::And(positive, hn::Gt(a[at(j, j)], hn::Zero(d)));
      const V inverse = hn::Div(set(1.0), a[at(j, j)]);
      V column[N];
#pragma GCC unroll 8
      for (int i = j + 1; i < N; ++i) {
        column[i] = a[at(i, j)];
        a[at(i, j)] = hn::Mul(column[i], inverse);
      }
#pragma GCC unroll 8
      for (int i = j + 1; i < N; ++i) {
#pragma GCC unroll 8
        for (int k = j + 1; k <= i; ++k) a[at(i, k)] = msub(a[at(i, k)], a[at(i, j)], column[k]);
        x[i] = msub(x[i], a[at(i, j)], x[j]);
      }
      x[j] = hn::Mul(x[j], inverse);
    }
#pragma GCC unroll 8
    for (int j = N - 1; j > 0; --j)
#pragma GCC unroll 8
      for (int i = 0; i < j; ++i) x[i] = msub(x[i], a[at(j, i)], x[j]);
    return positive;
  }

  /// Changes what does not fit, in every lane; lanes in which something did not.
  HWY_INLINE std::uint8_t exchange(const TiltTerms& t, double dual_tolerance, std::uint8_t lanes) {
    const V primal = set(t.primal_tolerance), dual = set(dual_tolerance);
    std::uint8_t changed = 0;
    for (int i = 0; i < N; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::uint8_t held = low[i] | high[i];
      const auto below =
          static_cast<std::uint8_t>(bits(hn::Lt(x[i], hn::Sub(set(t.lower[k]), primal))) & ~held);
      const auto above =
          static_cast<std::uint8_t>(bits(hn::Gt(x[i], hn::Add(set(t.upper[k]), primal))) & ~held);
      std::uint8_t release = 0;
      if ((held & lanes) != 0) {
        V slope = g[i];
        for (int j = 0; j < N; ++j) slope = madd(slope, h[sym(i, j)], x[j]);
        release = static_cast<std::uint8_t>((low[i] & bits(hn::Lt(slope, hn::Neg(dual)))) |
                                            (high[i] & bits(hn::Gt(slope, dual))));
      }
      changed = static_cast<std::uint8_t>(changed | below | above | release);
      low[i] = static_cast<std::uint8_t>((low[i] & ~release) | below);
      high[i] = static_cast<std::uint8_t>((high[i] & ~release) | above);
    }
    return changed & lanes;
  }

  /// Equation 4.3, summed from its terms: tracking is many orders larger than what tells the tilts apart.
  HWY_INLINE V cost(const TiltTerms& t, const TiltPrograms& p, int first) {
    const V c = hn::Load(d, p.c.data() + first), s = hn::Load(d, p.s.data() + first);
    V sum = hn::Zero(d), cu[N], su[N];
    for (int i = 0; i < N; ++i) {
      const auto k = static_cast<std::size_t>(i);
      x[i] = hn::Min(hn::Max(x[i], set(t.lower[k])), set(t.upper[k]));
      cu[i] = hn::Mul(c, x[i]);
      su[i] = hn::Mul(s, x[i]);
      const V step = hn::Sub(x[i], set(p.previous[k]));
      sum = madd(sum, hn::Mul(step, step), set(p.rate[k]));
      sum = madd(sum, hn::Mul(x[i], x[i]), set(p.input[k]));
    }
    for (std::size_t r = 0; r < 6; ++r) {
      V even = hn::Neg(set(p.target[r])), odd = hn::Zero(d);
      for (int i = 0; i < N; ++i) {
        const auto& row = t.rows[r][static_cast<std::size_t>(i)];
        even = madd(even, set(row[0]), cu[i]);
        odd = madd(odd, set(row[1]), su[i]);
        if (t.constant_part) odd = madd(odd, set(row[2]), x[i]);
      }
      const V missing = hn::Add(even, odd);
      sum = madd(sum, hn::Mul(missing, missing), set(t.weight[r]));
    }
    return sum;
  }

  static void run(const TiltTerms& t, TiltPrograms& p) {
    p.solved = 0;
    p.sweeps = 0;
    for (int first = 0; first < p.count; first += kLanes) {
      Lanes l;
      l.assemble(t, p, first);
      const auto asked = static_cast<std::uint8_t>((1u << std::min(kLanes, p.count - first)) - 1u);
      std::uint8_t unsettled = asked, positive = asked;
      int sweeps = 0;
      while (unsettled != 0 && sweeps < kMaxSweeps) {
        ++sweeps;
        std::uint8_t any = 0;
        for (int i = 0; i < N; ++i) any = static_cast<std::uint8_t>(any | l.low[i] | l.high[i]);
        positive =
            positive & bits((any & asked) != 0 ? l.template solve<true>(t) : l.template solve<false>(t));
        unsettled = l.exchange(t, p.dual_tolerance, asked);
      }
      hn::Store(l.cost(t, p, first), d, p.cost.data() + first);
      p.solved = static_cast<std::uint8_t>(p.solved | ((positive & ~unsettled & asked) << first));
      p.sweeps = std::max(p.sweeps, sweeps);
      for (int i = 0; i < N; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const auto kept = static_cast<std::uint8_t>(~(asked << first));
        p.at_low[k] = static_cast<std::uint8_t>((p.at_low[k] & kept) | ((l.low[i] & asked) << first));
        p.at_high[k] = static_cast<std::uint8_t>((p.at_high[k] & kept) | ((l.high[i] & asked) << first));
      }
    }
  }
};

void SolveTilts(const TiltTerms& terms, TiltPrograms& programs) {
  if (terms.n <= 6)
    Lanes<6>::run(terms, programs);
  else
    Lanes<8>::run(terms, programs);
}

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::allocation
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace omniflight::allocation {

HWY_EXPORT(SolveTilts);

void solve_tilts(const TiltTerms& terms, TiltPrograms& programs) {
  HWY_DYNAMIC_DISPATCH(SolveTilts)(terms, programs);
}

}  // namespace omniflight::allocation
#endif
