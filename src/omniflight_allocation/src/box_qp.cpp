#include "omniflight_allocation/box_qp.hpp"

#include <limits>

namespace omniflight::allocation {
namespace {

constexpr double kPrimalTolerance = 1e-12;  // of the largest bound
constexpr double kDualTolerance = 1e-14;    // of 1 + max |g|, with max diag H = 1; rounding is 1e-15
constexpr int kBlockTrials = 5;             // block exchanges without progress before single pivots
constexpr int kMaxIterations = 1000;

// The problem in scaled variables v = u / scale. N is the size where it is known when compiling (loops then
// unroll), 0 otherwise.
template <int N>
struct Problem {
  static constexpr int kCapacity = N > 0 ? N : kMaxInputs;
  int runtime_n = N;
  double h[kCapacity][kCapacity];
  double g[kCapacity], lo[kCapacity], hi[kCapacity], v[kCapacity], gradient[kCapacity];
  std::int8_t state[kCapacity];

  int n() const { return N > 0 ? N : runtime_n; }

  // v of the free variables with the others at their bounds; false when a pivot is not positive. Bound rows
  // become rows of the identity, so that the elimination has the same shape for every active set.
  bool solve_free(const double* rhs_free, bool at_bounds) {
    alignas(64) double a[kCapacity][kCapacity];
    double b[kCapacity], open[kCapacity], held[kCapacity];
    for (int i = 0; i < n(); ++i) {
      open[i] = state[i] == 0 ? 1.0 : 0.0;
      held[i] = state[i] == 0 || !at_bounds ? 0.0 : state[i] < 0 ? lo[i] : hi[i];
      b[i] = rhs_free[i];
    }
    for (int j = 0; j < n(); ++j) {
      for (int i = 0; i < n(); ++i) a[j][i] = open[j] * open[i] * h[j][i];
      a[j][j] += 1.0 - open[j];
      for (int i = 0; i < n(); ++i) b[i] -= h[j][i] * held[j];
    }
    for (int i = 0; i < n(); ++i) b[i] = open[i] * b[i] + held[i];
    for (int j = 0; j < n(); ++j) {
      if (!(a[j][j] > 0.0)) return false;
      const double inverse = 1.0 / a[j][j];
      for (int i = j + 1; i < n(); ++i) {
        const double factor = a[j][i] * inverse;
        for (int k = 0; k < n(); ++k) a[i][k] -= factor * a[j][k];
        b[i] -= factor * b[j];
      }
      b[j] *= inverse;
      for (int k = 0; k < n(); ++k) a[j][k] *= inverse;
    }
    for (int j = n() - 1; j > 0; --j)
      for (int i = 0; i < j; ++i) b[i] -= a[i][j] * b[j];
    for (int i = 0; i < n(); ++i) v[i] = b[i];
    return true;
  }

  void update_gradient() {
    for (int i = 0; i < n(); ++i) gradient[i] = g[i];
    for (int j = 0; j < n(); ++j)
      for (int i = 0; i < n(); ++i) gradient[i] += h[j][i] * v[j];
  }

  // The state variable i should have, seen from the current v and gradient.
  std::int8_t wanted(int i, double dual_tolerance) const {
    if (state[i] == 0) {
      if (v[i] < lo[i] - kPrimalTolerance) return -1;
      if (v[i] > hi[i] + kPrimalTolerance) return 1;
      return 0;
    }
    return state[i] * gradient[i] > dual_tolerance ? std::int8_t{0} : state[i];
  }

  double residual() const {
    double worst = 0.0;
    for (int i = 0; i < n(); ++i) {
      const double moved = std::min(std::max(v[i] - gradient[i], lo[i]), hi[i]);
      worst = std::max(worst, std::abs(v[i] - moved));
    }
    return worst;
  }

  void clip() {
    for (int i = 0; i < n(); ++i) v[i] = std::min(std::max(v[i], lo[i]), hi[i]);
  }

  QpStatus pivot(int& iterations) {
    double rhs[kCapacity], largest = 0.0;
    for (int i = 0; i < n(); ++i) rhs[i] = -g[i], largest = std::max(largest, std::abs(g[i]));
    const double dual_tolerance = kDualTolerance * (1.0 + largest);
    int fewest = std::numeric_limits<int>::max(), trials = kBlockTrials;
    for (iterations = 1; iterations <= kMaxIterations; ++iterations) {
      if (!solve_free(rhs, true)) return QpStatus::not_convex;
      update_gradient();
      int wrong = 0, last = -1;
      for (int i = 0; i < n(); ++i)
        if (wanted(i, dual_tolerance) != state[i]) ++wrong, last = i;
      if (wrong == 0) return QpStatus::solved;
      bool block = true;
      if (wrong < fewest)
        fewest = wrong, trials = kBlockTrials;
      else if (trials > 0)
        --trials;
      else
        block = false;
      for (int i = block ? 0 : last; i <= last; ++i) state[i] = wanted(i, dual_tolerance);
    }
    return QpStatus::iteration_limit;
  }

  // One correction of the free variables from the residual; kept only where it helps.
  double refine(double before) {
    double rhs[kCapacity], old[kCapacity];
    for (int i = 0; i < n(); ++i) rhs[i] = -gradient[i], old[i] = v[i];
    if (!solve_free(rhs, false)) return before;
    for (int i = 0; i < n(); ++i) v[i] += old[i];
    clip();
    update_gradient();
    const double after = residual();
    if (after <= before) return after;
    for (int i = 0; i < n(); ++i) v[i] = old[i];
    return before;
  }
};

template <int N>
void solve(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
           const ActiveSet& start, double h_scale, double scale, BoxQpSolution& out) {
  Problem<N> p;
  const int n = static_cast<int>(g.size());
  p.runtime_n = n;
  const double inverse_h = 1.0 / h_scale, inverse_g = 1.0 / (h_scale * scale), inverse_u = 1.0 / scale;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) p.h[i][j] = p.h[j][i] = H(i, j) * inverse_h;
    p.g[j] = g[j] * inverse_g;
    p.lo[j] = lower[j] * inverse_u;
    p.hi[j] = upper[j] * inverse_u;
    const auto guess = start[static_cast<std::size_t>(j)];
    p.state[j] = guess < 0 && std::isfinite(p.lo[j])   ? std::int8_t{-1}
                 : guess > 0 && std::isfinite(p.hi[j]) ? std::int8_t{1}
                                                       : std::int8_t{0};
  }
  out.status = p.pivot(out.iterations);
  if (out.status == QpStatus::not_convex) return;
  p.clip();
  p.update_gradient();
  out.kkt_residual = p.residual();
  if (out.status == QpStatus::solved && out.kkt_residual > 1e-14)
    out.kkt_residual = p.refine(out.kkt_residual);
  out.u.resize(n);
  for (int i = 0; i < n; ++i) {
    // the unscaled bound itself where it is active, and never past it by rounding
    const double u = p.state[i] < 0 ? lower[i] : p.state[i] > 0 ? upper[i] : p.v[i] * scale;
    out.u[i] = std::min(std::max(u, lower[i]), upper[i]);
    out.active_set[static_cast<std::size_t>(i)] = p.state[i];
    out.active_bounds += p.state[i] != 0;
  }
}

}  // namespace

const char* to_string(QpStatus status) {
  switch (status) {
    case QpStatus::solved:
      return "solved";
    case QpStatus::not_finite:
      return "not finite";
    case QpStatus::bad_size:
      return "bad size";
    case QpStatus::bad_bounds:
      return "a lower bound above its upper bound";
    case QpStatus::not_convex:
      return "not positive definite";
    case QpStatus::iteration_limit:
      return "iteration limit";
  }
  return "unknown";
}

BoxQpSolution solve_box_qp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
                           const ActiveSet& start) {
  BoxQpSolution out;
  const auto n = g.size();
  if (n < 1 || n > kMaxInputs || H.rows() != n || H.cols() != n || lower.size() != n || upper.size() != n)
    return out;
  double h_scale = 0.0, scale = 0.0;
  for (Eigen::Index j = 0; j < n; ++j) {
    bool finite = std::isfinite(g[j]) && !std::isnan(lower[j]) && !std::isnan(upper[j]);
    for (Eigen::Index i = j; i < n; ++i) finite = finite && std::isfinite(H(i, j));
    if (!finite) return out.status = QpStatus::not_finite, out;
    if (lower[j] > upper[j] || lower[j] == HUGE_VAL || upper[j] == -HUGE_VAL)
      return out.status = QpStatus::bad_bounds, out;
    if (!(H(j, j) > 0)) return out.status = QpStatus::not_convex, out;
    h_scale = std::max(h_scale, H(j, j));
    for (const double bound : {lower[j], upper[j]})
      if (std::isfinite(bound)) scale = std::max(scale, std::abs(bound));
  }
  if (scale == 0.0) scale = 1.0;
  switch (n) {
    case 4:
      solve<4>(H, g, lower, upper, start, h_scale, scale, out);
      break;
    case 6:
      solve<6>(H, g, lower, upper, start, h_scale, scale, out);
      break;
    case 8:
      solve<8>(H, g, lower, upper, start, h_scale, scale, out);
      break;
    default:
      solve<0>(H, g, lower, upper, start, h_scale, scale, out);
  }
  return out;
}

}  // namespace omniflight::allocation
